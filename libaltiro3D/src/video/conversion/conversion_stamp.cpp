#include "video/conversion/conversion_run.hpp"

#include "altiro3D/display.hpp"
#include "altiro3D/file_io.hpp"
#include "altiro3D/version.hpp"
#include "base/checks.hpp"
#include "base/json_reader.hpp"
#include "base/state_bytes.hpp"
#include "base/text.hpp"
#include "video/motion/motion.hpp"

#include <thread>
#include <tuple>
#include <type_traits>
#include <utility>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr const char* kDepthRange = "depth range";

// Identifies the state of a file or of a directory of pictures.
std::string stampOf(const fs::path& path) {
    std::error_code error; // opening it reports what is wrong
    if (!fs::is_directory(path, error)) return fileStamp(path);
    const std::vector<fs::path> files = listImages(path);
    std::string all;
    for (const fs::path& file : files) // the name decides the frame that a picture belongs to
        all += file.filename().string() + '\0' + fileStamp(file) + '\n';
    return std::to_string(files.size()) + " files, " + fingerprintText(checksum(all));
}

std::string contentsOf(const NativeLut& map) {
    std::uint64_t sum = 0;
    for (int colour = 0; colour < 3; ++colour)
        sum = mixIn(sum, pictureHash(map.channel(colour)));
    return fingerprintText(sum);
}

// Settings of a network that are not in its file.
Json feedingOf(const DepthNetwork& network) {
    const NetworkProfile& profile = network.profile();
    return {{"size", pairText(network.inputSize().width, network.inputSize().height)},
            {"shape", {static_cast<int>(profile.inputShape), profile.multipleOf}},
            {"channels", static_cast<int>(profile.channelOrder)},
            {"scale", profile.scale},
            {"mean", profile.mean},
            {"std", profile.std},
            {"resize", static_cast<int>(profile.resizeKernel)},
            {"output", static_cast<int>(profile.output)},
            {"engine", static_cast<int>(network.engine())},
            {"processor", static_cast<int>(network.target())}};
}

// Whether a struct has a function fields() that gives all of its fields.
template <typename T, typename = void>
constexpr bool kHasFields = false;
template <typename T>
constexpr bool kHasFields<T, std::void_t<decltype(T::fields(std::declval<T&>()))>> = true;

// Appends the numbers of options, in the order of their fields.
template <typename T>
void addNumbers(Json& all, const T& value) {
    if constexpr (kHasFields<T>) {
        std::apply([&](const auto&... fields) { (addNumbers(all, fields), ...); },
                   T::fields(value));
    } else if constexpr (std::is_same_v<T, std::optional<DepthFlaws>>) {
        if (value) addNumbers(all, *value);
        if (!value) all.push_back(nullptr); // they are measured
    } else if constexpr (std::is_enum_v<T>) {
        all.push_back(static_cast<int>(value));
    } else {
        all.push_back(value);
    }
}

template <typename Options>
Json numbersOf(const Options& options) {
    Json all = Json::array();
    addNumbers(all, options);
    return all;
}

Json encodingOf(const VideoWriterOptions& options) {
    Json colours = Json::array();
    if (options.matrix) colours.push_back(static_cast<int>(*options.matrix));
    if (options.range) colours.push_back(static_cast<int>(*options.range));
    return {{"codec", static_cast<int>(options.codec)},
            {"compatible", options.compatible},
            {"crf", options.crf},
            {"maxRate", options.maxRate},
            {"preset", static_cast<int>(options.preset)},
            {"colours", colours},
            {"copied", {options.audio, options.subtitles, options.chapters, options.metadata}},
            {"tags", options.tags}};
}

} // namespace

void takeDepthRange(VideoConversion& conversion, const Json& settings) {
    const auto found = settings.find(kDepthRange);
    if (!conversion.given || conversion.given->range || found == settings.end()) return;
    const Json range =
        found->is_string() ? Json::parse(found->get<std::string>(), nullptr, false) : Json();
    if (!range.is_array() || range.size() != 2 || !range[0].is_number() || !range[1].is_number())
        return; // it is measured again
    conversion.given->range = DepthRange{range[0].get<double>(), range[1].get<double>()};
}

RunSettings conversionStamp(const VideoConversion& conversion, const QuiltLayout& layout) {
    RunSettings stamp = conversion.settings;
    const auto text = [](const Json& value) {
        return value.dump(-1, ' ', false, Json::error_handler_t::replace);
    };
    const auto add = [&](const char* name, const Json& value) { stamp[name] = text(value); };
    stamp["video"] = stampOf(conversion.input);
    if (conversion.given) {
        const GivenVideoDepth& given = *conversion.given;
        if (!given.rgbd) stamp["depth video"] = stampOf(given.source);
        add("given depth",
            {given.rgbd ? static_cast<int>(given.rgbd->side) : -1, static_cast<int>(given.kind)});
        if (given.rgbd) add("shape of the halves", static_cast<int>(given.rgbd->halves));
        if (given.range) add(kDepthRange, {given.range->low, given.range->high});
    } else if (conversion.depth) {
        const DepthSource& depth = *conversion.depth;
        stamp["depth"] = depth.description();
        if (depth.network() != nullptr) {
            stamp["network"] = stampOf(depth.network()->file());
            add("network profile", feedingOf(*depth.network()));
        }
    }
    stamp["quilt"] = layout.text();
    if (conversion.fromQuilt) stamp["shape of the views"] = std::to_string(conversion.viewAspect);
    if (conversion.map) {
        stamp["map"] = contentsOf(*conversion.map);
        stamp["display"] = fingerprintText(conversion.map->calibrationFingerprint());
    } else if (conversion.display) {
        stamp["display"] = fingerprintText(fingerprint(conversion.display->calibration));
        add("order of views", static_cast<int>(conversion.display->invert));
    }
    add("product", static_cast<int>(conversion.product));
    if (conversion.product == VideoProduct::Stereo) {
        const VideoEyes& eyes = conversion.eyes;
        add("eyes", {static_cast<int>(eyes.picture), static_cast<int>(eyes.from), eyes.swapped,
                     eyes.filmed});
    }
    if (conversion.product == VideoProduct::Rgbd)
        add("shape of the halves made", static_cast<int>(conversion.rgbdHalves));
    if (conversion.stereo)
        add("both eyes", {static_cast<int>(conversion.stereo->layout),
                          static_cast<int>(conversion.stereo->halves)});
    add("part",
        {conversion.part.from, conversion.part.to, conversion.part.format,
         conversion.part.formatOptions, conversion.part.deinterlace, conversion.part.joinsVideos});
    for (const RecipeField& field : recipeFields())
        stamp["views: " + field.name] = field.text(conversion.recipe);
    add("ways of rendering", numbersOf(static_cast<const NativeOptions&>(conversion.recipe)));
    add("steps of depth", numbersOf(conversion.depthOptions));
    add("encoder", encodingOf(conversion.encoding));
    const int threads = conversion.encoding.threads; // encoders divide frames among threads
    stamp["threads"] = std::to_string(
        threads > 0 ? threads : static_cast<int>(std::thread::hardware_concurrency()));
    stamp["threads of OpenCV"] =
        std::to_string(cv::getNumThreads()); // the output of networks depends on them
    stamp["version"] = version();
    return stamp;
}

} // namespace altiro3D
