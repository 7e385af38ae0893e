#include "cli/go_folder.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "cli/foreign_json.hpp"
#include "cli/outputs.hpp"

#include <algorithm>
#include <charconv>
#include <nlohmann/json.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

// What the Go reads first.
struct Playing {
    fs::path file;
    bool isThere = false;
    Json json = {{"model", "toolkit"}, {"schema", "0.1"}, {"playlists", Json::array()}};
};

constexpr std::uintmax_t kMaxBytes = std::uintmax_t{1} << 20;

Playing readPlaying(const fs::path& storage) {
    Playing playing{storage / "currentlyPlaying.json"};
    playing.isThere = isThere(playing.file);
    if (!playing.isThere) return playing;
    const std::string expected = "a list of playlists of a Looking Glass Go";
    playing.json =
        parseForeignJson(readFile(playing.file, kMaxBytes), playing.file.string(), expected);
    const Json& json = playing.json;
    if (!json.is_object() || !json.contains("playlists") || !json["playlists"].is_array())
        throw Error(ErrorCode::BadFormat, playing.file.string(),
                    "has no list \"playlists\", expected " + expected);
    return playing;
}

// The first number that no folder has.
std::string nextNumber(const fs::path& folder) {
    int last = 0;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
        const std::string name = it->path().filename().string();
        int number = 0;
        const auto read = std::from_chars(name.data(), name.data() + name.size(), number);
        if (read.ec == std::errc() && number < 1000000) last = std::max(last, number);
    }
    return std::to_string(last + 1);
}

} // namespace

void GoFolder::addOptions(CommandLine& commandLine, const std::string& things) {
    commandLine.addAdvanced({"go"},
                            "Instead of Natives: make quilts of the " + things +
                                " and a playlist on the storage of a Looking Glass Go, which "
                                "plays them without a computer. DIR is that storage, or a folder "
                                "to copy there; its contents stay.",
                            "DIR");
    commandLine.addAdvanced({"each"},
                            "With --go and --bridge: show each for S seconds (default 20).", "S");
}

std::optional<GoFolder> GoFolder::of(const CommandLine& commandLine) {
    fs::path storage;
    double seconds = 20;
    commandLine.take({{"go", storage}, {"each", seconds, 0.1, 1e6}});
    if (storage.empty()) {
        commandLine.refuseWithout("bridge", {"each"},
                                  " applies to --go and --bridge, expected one of them");
        return std::nullopt;
    }
    commandLine.exclude("go", "bridge");
    return GoFolder(storage, seconds);
}

GoFolder::GoFolder(fs::path storage, double seconds)
    : storage_(std::move(storage)), seconds_(seconds) {
    if (isThere(storage_) && !isDirectory(storage_))
        throw Error(ErrorCode::WriteFailed, storage_.string(),
                    "is a file, expected the folder of a Go's storage");
    (void)readPlaying(storage_); // before any work
    const fs::path contents = storage_ / "LKG" / "Content";
    number_ = nextNumber(contents);
    content_ = contents / number_;
}

fs::path GoFolder::quiltFile(std::size_t index, const std::string& stem) const {
    std::string number = std::to_string(index + 1);
    number.insert(0, 3 - std::min<std::size_t>(number.size(), 3), '0');
    std::string name = stem; // without another layout
    if (lowerCase(stem).find("_qs") != std::string::npos && parseQuiltName(stem + ".jpg"))
        name.resize(lowerCase(stem).rfind("_qs"));
    const ChosenDisplay go = goDisplay();
    return quiltFileName(content_ / (number + "_" + inFileName(name) + ".jpg"), go.quilt,
                         go.aspect());
}

void GoFolder::requireSpace(std::size_t quilts) const {
    fs::path folder = fs::absolute(storage_);
    while (!isThere(folder) && folder.has_relative_path())
        folder = folder.parent_path();
    std::error_code error;
    const fs::space_info space = fs::space(folder, error);
    const auto wanted = static_cast<std::uintmax_t>(goDisplay().quilt.size().area()) * quilts;
    if (error || space.available >= wanted) return; // a JPEG has less than a byte per px
    throw Error(ErrorCode::WriteFailed, storage_.string(),
                "has " + std::to_string(space.available / 1000000) + " MB free, expected " +
                    std::to_string(wanted / 1000000) + " MB for " + counted(quilts, "quilt"));
}

void GoFolder::finish(const std::vector<fs::path>& quilts, Messages& messages) const {
    if (quilts.empty()) {
        std::error_code ignored;
        fs::remove(content_, ignored); // only if it is empty
        return;
    }
    const ChosenDisplay go = goDisplay();
    const Json sidecar = {{"mediaType", "quilt"},
                          {"quilt_settings",
                           {{"viewX", go.quilt.columns},
                            {"viewY", go.quilt.rows},
                            {"viewTotal", go.quilt.viewCount},
                            {"aspect", go.aspect()},
                            {"invertViews", false}}},
                          {"focus", 0.0},
                          {"zoom", 1},
                          {"duration", seconds_}};
    std::string list = "#EXTM3U\n";
    for (const fs::path& quilt : quilts) {
        writeFile(quilt.string() + ".json", sidecar.dump(4) + "\n");
        list += "#EXTINF:" + fixed(seconds_, seconds_ < 10 ? 1 : 0) + "," + quilt.stem().string() +
                "\n" + quilt.filename().string() + "\n";
    }
    const fs::path playlist = content_ / "playlist.m3u";
    writeFile(playlist, list);
    Playing playing = readPlaying(storage_);
    if (playing.isThere)
        writeFile(playing.file.string() + ".bak", readFile(playing.file, kMaxBytes));
    playing.json["playlists"].push_back(
        {{"title", "altiro3D " + number_}, {"path", "/LKG/Content/" + number_ + "/playlist.m3u"}});
    writeFile(playing.file,
              playing.json.dump(4, ' ', false, Json::error_handler_t::replace) + "\n");
    messages.say(playlist.string() + ": " + counted(quilts.size(), "quilt") +
                 " that a Go plays without a computer");
}

ChosenDisplay goDisplay() {
    Calibration nominal;
    nominal.serial = "LKG-E";
    nominal.pitch = 80.7;
    nominal.slope = -6.66;
    nominal.viewCone = 54;
    nominal.DPI = 491;
    nominal.screenW = 1440;
    nominal.screenH = 2560;
    return {displayOf(nominal, "a Looking Glass Go"), {}, {}};
}

} // namespace altiro3D::tools
