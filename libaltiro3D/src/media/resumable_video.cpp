#include "media/resumable_video.hpp"

#include "altiro3D/file_io.hpp"
#include "base/checks.hpp"
#include "base/text.hpp"
#include "media/video_picture.hpp"

#include <cerrno>
#include <set>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

// Settings whose values identify the state of a file.
const std::set<std::string> kFiles = {"video", "depth video", "network"};

constexpr const char* kFormat = "altiro3D video run";
constexpr int kVersion = 2;
constexpr const char* kState = ".state"; // extension of saved states
constexpr int kMaxSegmentFrames = 100000;
constexpr std::uintmax_t kMaxStateBytes = std::uintmax_t{1} << 30;

// Locks a directory against other processes while the handle is open.
FileHandle lockDirectory(const fs::path& directory) {
    FileHandle handle = openFile(directory, OpenFor::Directory);
    if (!handle.isOpen()) {
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "cannot be opened: " + reasonOf(errno));
    }
    if (!lockFile(handle)) {
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "is in use by another process, expected one run at a time");
    }
    return handle;
}

// Removes the directory of a run that has kept nothing.
void removeRun(const fs::path& directory, FileHandle& lock) {
    std::error_code ignored;
    fs::remove(directory / numberedName(0, kState), ignored);
    fs::remove(directory / "run.json", ignored);
    unlockToRemove(lock);
    fs::remove(directory, ignored); // fails if other files are in it
}

} // namespace

std::int64_t wholeNumber(const Json& value, std::int64_t least, std::int64_t most) {
    require(value.is_number_integer());
    const auto number = value.get<std::int64_t>(); // those of 64 bits become negative
    require(number >= least && number <= most);
    return number;
}

std::uint64_t bitsOf(const Json& value) {
    require(value.is_number_unsigned());
    return value.get<std::uint64_t>();
}

std::string runFileText(const Json& value) {
    return value.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json jsonOf(const VideoSegment& segment) {
    return {{"file", segment.file.filename().string()},
            {"frames", segment.frames},
            {"pts", segment.pts},
            {"end", segment.end},
            {"times", segment.times},
            {"bytes", segment.bytes},
            {"reorderedPlaces", segment.reorderedPlaces}};
}

VideoSegment segmentOf(const Json& entry, const fs::path& folder, int mostFrames) {
    VideoSegment segment;
    segment.file = folder / entry.at("file").get<std::string>();
    segment.frames = wholeNumber(entry.at("frames"), 1, mostFrames);
    segment.pts = wholeNumber(entry.at("pts"), 0, kLatestPts);
    segment.end = wholeNumber(entry.at("end"), 0, kLatestPts);
    segment.times = bitsOf(entry.at("times"));
    segment.bytes = static_cast<std::uintmax_t>(wholeNumber(entry.at("bytes"), 0, kLatestPts));
    segment.reorderedPlaces =
        static_cast<int>(wholeNumber(entry.at("reorderedPlaces"), 0, mostFrames));
    return segment;
}

Json readRunFile(const fs::path& directory) {
    const fs::path file = directory / "run.json";
    return parseJson(readFile(file, kMaxRunBytes), file.string(), "an unfinished run", kRunLimits);
}

Json settingsJson(const RunSettings& settings) {
    return Json::parse(Json(settings).dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string differenceOf(const Json& before, const Json& now) {
    const auto text = [](const Json& all, const std::string& name) {
        if (!all.contains(name)) return std::string("not set");
        if (!all[name].is_string()) return all[name].dump();
        const auto given = all[name].get<std::string>();
        return given.empty() ? std::string("set") : given;
    };
    for (const bool inBoth : {false, true}) {
        for (const Json* all : {&before, &now}) {
            for (const auto& item : all->items()) {
                const std::string& name = item.key();
                if ((before.contains(name) && now.contains(name)) != inBoth) continue;
                if (text(before, name) == text(now, name)) continue;
                if (inBoth && kFiles.count(name) > 0)
                    return "the file of the " + name + " has changed";
                return name + " was " + text(before, name) + " and is " + text(now, name);
            }
        }
    }
    return {};
}

ResumableVideoWriter::ResumableVideoWriter(const fs::path& path, const VideoWriterOptions& options,
                                           const ResumableVideoOptions& resumable,
                                           VideoReader* source)
    : path_(path), directory_(unfinishedVideoDirectory(path)), options_(options),
      segmentFrames_(resumable.segmentFrames) {
    check(segmentFrames_ >= 1 && segmentFrames_ <= kMaxSegmentFrames, "segmentFrames",
          "is " + std::to_string(segmentFrames_) + ", expected 1.." +
              std::to_string(kMaxSegmentFrames));
    if (source != nullptr && !options_.colour)
        options_.colour = shownColour(source->facts().colour);
    // Outputs that cannot be written must fail now, not after all frames are made.
    notes_ = VideoWriter(path_, options_, source).notes();
    settings_ = settingsJson(resumable.settings);
    const bool there = isVideoUnfinished(path_);
    if (there && !resumable.resume) {
        throw Error(ErrorCode::WriteFailed, path_.string(),
                    "an unfinished run of it is kept in " + directory_.string() +
                        ", expected it to be resumed or discarded");
    }
    std::error_code error;
    fs::create_directory(directory_, error);
    if (error) {
        throw Error(ErrorCode::WriteFailed, directory_.string(),
                    "cannot be made: " + error.message());
    }
    lock_ = lockDirectory(directory_);
    // Removes small files that an interrupted run left incomplete.
    for (fs::directory_iterator entry(directory_, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        std::error_code ignored;
        if (name.rfind(".altiro3D-", 0) == 0) fs::remove(entry->path(), ignored);
    }
    if (there) readRun();
    try {
        if (!there) writeRun();
        writer_.emplace(directory_, options_, segmentFrames_, segments_.size(), kept_.nextPts);
    } catch (...) {
        if (!there) removeRun(directory_, lock_);
        throw;
    }
}

ResumableVideoWriter::~ResumableVideoWriter() {
    if (complete_ || keepsWork()) return;
    if (writer_) writer_->drop();
    removeRun(directory_, lock_);
}

void ResumableVideoWriter::readRun() {
    const fs::path file = directory_ / "run.json";
    const auto fail = [&](const std::string& problem) {
        throw Error(ErrorCode::BadFormat, file.string(), problem + ", expected an unfinished run");
    };
    const Json run = readRunFile(directory_);
    readingMembers(file, [&] {
        if (run.at("format") != kFormat || run.at("version") != kVersion) fail("is not a run");
        const std::string other = differenceOf(run.at("settings"), settings_);
        if (!other.empty()) {
            throw Error(ErrorCode::Mismatch, path_.string(),
                        "was begun with other settings (" + other + "), expected the same");
        }
        if (run.at("segmentFrames") != segmentFrames_ ||
            run.at("timeBase") !=
                Json({options_.timeBase.numerator, options_.timeBase.denominator})) {
            fail("was begun for another video");
        }
        for (const Json& entry : run.at("segments")) {
            const std::string name = entry.at("file");
            const std::string state = entry.at("state");
            VideoSegment segment = segmentOf(entry, directory_, segmentFrames_);
            // Each has a fixed name; any other name could lead out of the directory.
            const std::size_t number = segments_.size();
            const auto checkName = [&](const std::string& listed, const std::string& expected) {
                if (listed != expected) fail("lists \"" + listed + "\" in place of " + expected);
            };
            checkName(name, segmentName(number, options_.codec));
            if (!state.empty()) checkName(state, numberedName(number, kState));
            std::error_code error;
            if (fs::file_size(segment.file, error) != segment.bytes || error)
                fail("lists " + name + ", which is missing or damaged");
            if (segment.pts < kept_.nextPts || segment.end <= segment.pts)
                fail("lists " + name + " with impossible times");
            kept_.frames += segment.frames;
            kept_.nextPts = segment.end;
            segments_.push_back(std::move(segment));
            states_.push_back(state);
        }
    });
    listed_ = segments_.size();
    if (!states_.empty() && !states_.back().empty())
        kept_.state.bytes = readFile(directory_ / states_.back(), kMaxStateBytes);
}

void ResumableVideoWriter::writeRun() {
    Json list = Json::array();
    for (std::size_t i = 0; i < segments_.size(); ++i) {
        list.push_back(jsonOf(segments_[i]));
        list.back()["state"] = states_[i];
    }
    const Json run = {{"format", kFormat},
                      {"version", kVersion},
                      {"settings", settings_},
                      {"timeBase", {options_.timeBase.numerator, options_.timeBase.denominator}},
                      {"segmentFrames", segmentFrames_},
                      {"segments", list}};
    writeFile(directory_ / "run.json", runFileText(run));
    listed_ = segments_.size();
}

void ResumableVideoWriter::write(const VideoFrame& frame, const SavedState& state) {
    check(!finished_, "write", "comes after finish()");
    if (writer_->write(frame)) closeSegment(state, true);
}

void ResumableVideoWriter::closeSegment(const SavedState& state, bool listed) {
    const VideoSegment segment = writer_->end();
    std::string stateFile;
    if (listed && !state.bytes.empty()) {
        stateFile = numberedName(segments_.size(), kState);
        writeFile(directory_ / stateFile, state.bytes);
    }
    segments_.push_back(segment);
    states_.push_back(stateFile);
    if (!listed) return;
    writeRun();
    // Earlier states are no longer needed.
    if (states_.size() < 2) return;
    const std::string& old = states_[states_.size() - 2];
    std::error_code ignored;
    if (!old.empty()) fs::remove(directory_ / old, ignored);
}

void ResumableVideoWriter::finish(VideoReader* source, bool complete) {
    check(!finished_, "finish", "comes twice");
    const std::size_t whole = segments_.size();
    if (writer_->hasBegun()) closeSegment({}, complete);
    check(!segments_.empty(), "finish", "comes before the first frame");
    SegmentJoiner::join(path_, options_, segments_, source, complete, {}, notes_);
    finished_ = true;
    std::error_code ignored; // the file is there
    if (complete) {
        unlockToRemove(lock_);
        fs::remove_all(directory_, ignored);
        complete_ = true;
        listed_ = 0;
    } else if (segments_.size() > whole) {
        fs::remove(segments_.back().file, ignored);
        segments_.pop_back();
        states_.pop_back();
    }
}

fs::path unfinishedVideoDirectory(const fs::path& path) {
    return besideName(path, ".parts");
}

bool isVideoUnfinished(const fs::path& path) {
    std::error_code error;
    return fs::exists(unfinishedVideoDirectory(path) / "run.json", error);
}

void discardUnfinishedVideo(const fs::path& path) {
    if (!isVideoUnfinished(path)) return; // not our directory
    const fs::path directory = unfinishedVideoDirectory(path);
    FileHandle lock = lockDirectory(directory);
    unlockToRemove(lock);
    std::error_code error;
    fs::remove_all(directory, error);
    if (error) {
        throw Error(ErrorCode::WriteFailed, directory.string(),
                    "cannot be removed: " + error.message());
    }
}

} // namespace altiro3D
