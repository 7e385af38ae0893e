#include "media/video_input.hpp"

#include "altiro3D/error.hpp"
#include "base/byte_reader.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string_view>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

using Kind = VideoInput::Kind;

// Seeks to the index of an MP4 or QuickTime file, its box "moov".
// @param isMovie receives whether the file has boxes of such a file
// @return bytes of the box; 0 if it is missing
std::uint64_t seekIndex(std::ifstream& file, bool& isMovie) {
    std::uint64_t at = 0;
    for (int boxes = 0; boxes < 10000 && file.seekg(static_cast<std::streamoff>(at)); ++boxes) {
        std::string head(16, '\0');
        file.read(head.data(), 16);
        if (file.gcount() < 8) break;
        file.clear();
        const ByteReader reader(head, false);
        const std::uint64_t size = reader.u32(0) == 1 ? reader.u64(8) : reader.u32(0);
        const std::string_view type = reader.text(4, 4);
        if (type == "moov" && file.seekg(static_cast<std::streamoff>(at)))
            return size == 0 ? UINT64_MAX : size; // 0: up to the end of the file
        isMovie = isMovie || type == "ftyp" || type == "mdat";
        if (size < 8 || size > UINT64_MAX / 4 - at) break;
        at += size;
    }
    return 0;
}

// The part of a file that describes its streams: in MP4 the beginning of the box "moov", which has
// the sample entries, in Matroska the beginning of the file. Empty for other formats.
// @param format FFmpeg's name of it
std::string streamHead(const fs::path& path, std::string_view format) {
    std::error_code error;
    if (!fs::is_regular_file(path, error)) return {}; // others are read once
    std::ifstream file(path, std::ios::binary);
    const auto read = [&file](std::uint64_t size) {
        constexpr std::uint64_t kMostBytes = 1 << 24;
        std::string bytes(static_cast<std::size_t>(std::min(size, kMostBytes)), '\0');
        file.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
        bytes.resize(static_cast<std::size_t>(file.gcount()));
        return bytes;
    };
    constexpr std::uint64_t kTracks = 1 << 16; // Matroska's tracks are in front
    if (startsWith(format, "matroska")) return read(kTracks);
    if (!startsWith(format, "mov,")) return {};
    bool isMovie = false;
    return read(seekIndex(file, isMovie));
}

// Whether an MP4 or QuickTime file has boxes but not the one with its index.
bool lacksMovieIndex(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    bool isMovie = false;
    return seekIndex(file, isMovie) == 0 && isMovie;
}

// Throws with our own message if a path cannot be read.
void checkFile(const fs::path& path, const std::string& subject) {
    const FileState state = stateOf(path);
    if (state.error == ENOENT || state.error == ENOTDIR)
        throw Error(ErrorCode::NotFound, subject, "does not exist, expected a video file");
    if (!state.exists()) {
        throw Error(ErrorCode::ReadFailed, subject, "cannot be read: " + reasonOf(state.error));
    }
    if (state.isDirectory())
        throw Error(ErrorCode::ReadFailed, subject, "is a directory, expected a video file");
    if (state.isRegular() && state.size == 0)
        throw Error(ErrorCode::BadFormat, subject, "is empty, expected a video file");
}

// A pipe is opened once. MP4 files may have their index at the end, so they are copied first,
// unless they are made to be read as they come (with fragments).
// @return what to open
std::string openStream(VideoInput& input, const fs::path& path) {
    constexpr std::uintmax_t kMostCopied = std::uintmax_t{1} << 36;
    input.kind = Kind::Stream;
    input.file = path == "-" ? standardInput() : openFile(path, OpenFor::Reading);
    if (!input.file.isOpen()) {
        throw Error(ErrorCode::ReadFailed, input.subject, "cannot be read: " + reasonOf(errno));
    }
    const std::string start = waitingBytes(input.file);
    const std::string box = start.substr(std::min<std::size_t>(4, start.size()), 4);
    constexpr std::string_view kFirstBoxes[] = {"ftyp", "moov", "mdat", "wide", "free", "skip"};
    if (std::find(std::begin(kFirstBoxes), std::end(kFirstBoxes), box) != std::end(kFirstBoxes)) {
        const std::size_t index = start.find("moov");
        const bool isWhole = start.find("mvex", index) < start.find("moof", index);
        if (index < start.find("mdat") && isWhole) {
            input.head = start.substr(index);
        } else {
            input.file = unnamedCopy(input.file, input.subject, kMostCopied);
            input.kind = Kind::File;
            return "file:" + nameOf(input.file).string();
        }
    }
    return "pipe:" + std::to_string(input.file.get());
}

// The streams whose packets are encrypted.
std::set<int> encryptedStreams(const AVFormatContext& format, const std::string& boxes) {
    std::set<int> encrypted;
    std::size_t at = 0; // MP4 has a list of sample entries for each stream
    for (int i = 0; i < static_cast<int>(format.nb_streams); ++i) {
        constexpr std::size_t kEntry = 16; // from the name of the list to that of its first entry
        at = at == std::string::npos ? at : boxes.find("stsd", at + 1);
        const bool isNamed = at != std::string::npos && at + kEntry + 3 < boxes.size() &&
                             boxes.compare(at + kEntry, 3, "enc") == 0;
        const AVStream& stream = *format.streams[i];
        const std::uint32_t tag = stream.codecpar->codec_tag;
        if (isNamed || !tagOf(stream.metadata, "enc_key_id").empty() ||
            tag == MKTAG('d', 'r', 'm', 'i') || tag == MKTAG('d', 'r', 'm', 's'))
            encrypted.insert(i);
    }
    return encrypted;
}

} // namespace

void openContainer(VideoInput& input, const fs::path& path, const VideoReaderOptions& options) {
    quietFfmpeg();
    input.subject = path == "-" ? "standard input" : path.string();
    std::string url = "file:" + path.string();
    const AVInputFormat* wantedFormat = nullptr;
    std::string wanted = options.format;
    std::error_code noFile;
    const bool isCamera = wanted.empty() && path != "-" && fs::is_character_file(path, noFile);
    if (isCamera) wanted = "v4l2";
    if (!wanted.empty()) {
        wantedFormat = inputFormat(wanted);
        if ((wantedFormat->flags & AVFMT_NOFILE) != 0) {
            input.kind = Kind::Device;
            url = path.string();
        }
    }
    fs::path source = path;
    if (input.kind == Kind::File && path == "-") {
        // one that is a file is read as one: the index of an .mp4 may be at its end
        source = standardInputFile();
        input.kind = Kind::Stream;
        url = source.empty() ? openStream(input, path) : "file:" + source.string();
    } else if (input.kind == Kind::File) {
        checkFile(path, input.subject);
        if (givesBytesOnce(path)) url = openStream(input, path);
    }
    if (input.file.isOpen()) source = nameOf(input.file);

    Dictionary settings;
    for (const auto& [name, value] : options.formatOptions)
        settings.set(name, value);
    // A file must not open other files over the network.
    if (input.kind != Kind::Device) settings.set("protocol_whitelist", "file,pipe,crypto,data");
    AVFormatContext* raw = nullptr;
    int result = avformat_open_input(&raw, url.c_str(), wantedFormat, settings.address());
    if (result < 0) {
        // FFmpeg's Y4M reader returns "busy" for a picture beyond its limits.
        if (result == AVERROR_INVALIDDATA || result == AVERROR_EOF ||
            (input.kind == Kind::File && result == AVERROR(EBUSY))) {
            if (input.kind == Kind::File && lacksMovieIndex(source)) {
                throw Error(
                    ErrorCode::BadFormat, input.subject,
                    "has no index (moov): it is cut off or was never finished, expected a whole "
                    "file");
            }
            throw Error(ErrorCode::BadFormat, input.subject, "is not a video that FFmpeg can read");
        }
        if (result == AVERROR(ENOMEM)) checkMemory(nullptr);
        // Drivers of devices that are not cameras report this error when asked for their formats.
        if (isCamera &&
            (result == AVERROR(ENOTTY) || result == AVERROR(EINVAL) || result == AVERROR(ENODEV))) {
            throw Error(ErrorCode::BadFormat, input.subject,
                        "is a device but not a camera, expected a video file, a camera, or the "
                        "name of the device's format");
        }
        throw Error(ErrorCode::ReadFailed, input.subject, "cannot be read: " + ffmpegText(result));
    }
    input.format.reset(raw);
    if (const std::string unused = settings.firstName();
        !unused.empty() && unused != "protocol_whitelist") {
        throw Error(ErrorCode::InvalidArgument, "formatOptions",
                    "have \"" + unused + "\", which the format " + input.format->iformat->name +
                        " does not know");
    }
    if (std::strcmp(input.format->iformat->name, "tty") == 0) { // this format accepts any text
        throw Error(ErrorCode::BadFormat, input.subject, "is a text, expected a video file");
    }
    result = avformat_find_stream_info(raw, nullptr);
    if (result < 0 && raw->nb_streams == 0)
        throw Error(ErrorCode::BadFormat, input.subject, "cannot be read: " + ffmpegText(result));
    if (url.compare(0, 5, "file:") == 0) input.head = streamHead(source, raw->iformat->name);
    input.encrypted = encryptedStreams(*raw, input.head);
}

bool VideoInput::hasFixedTimes() const {
    return canSeek() && (format->iformat->flags & AVFMT_TS_DISCONT) == 0;
}

bool VideoInput::canSeek() const {
    return kind == Kind::File && format->start_time != AV_NOPTS_VALUE && !alternates &&
           twin == nullptr;
}

int VideoInput::readPacket(AVPacket& packet) {
    if (ahead.empty()) return av_read_frame(format.get(), &packet);
    av_packet_move_ref(&packet, ahead.front().get());
    ahead.pop_front();
    return 0;
}

} // namespace altiro3D
