#include "cli/eyes_options.hpp"

#include "altiro3D/image_io.hpp"
#include "cli/outputs.hpp"

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::tools {

namespace {

constexpr int kLayouts = static_cast<int>(EyesPicture::Checkerboard) + 1;

// As EyesPicture, and then "files" if that exists.
std::vector<std::string> layoutNames(bool files) {
    std::vector<std::string> names;
    for (int i = 0; i < kLayouts; ++i)
        names.emplace_back(nameOf(static_cast<EyesPicture>(i)).option);
    if (files) names.emplace_back("files");
    return names;
}

} // namespace

void addEyesOptions(CommandLine& commandLine, const std::string& output, bool files, bool keep) {
    commandLine.addAdvanced(
        {"stereo-layout"},
        "Layout of --" + output +
            ": sbs (side by side, default), sbs-half, cross (crossed eyes), tb (top and bottom), "
            "tb-half, anaglyph (red-cyan glasses), anaglyph-half, anaglyph-grey, "
            "rows (of a television with polarized rows), columns (of a screen with a barrier)" +
            (files ? ", " : " or ") + "checkerboard (of a DLP television)" +
            (files ? ", or files: two pictures, FILE_L and FILE_R" : "") +
            ". Each eye of sbs-half and tb-half is squeezed to half.",
        "LAYOUT", [files] { return layoutNames(files); });
    if (keep) {
        commandLine.addAdvanced({"stereo-keep"},
                                "left: the left eye sees the photo itself, and only the right "
                                "one's picture is made. By default the photo lies between both.",
                                "left");
    }
    commandLine.addAdvanced({"stereo-swap"}, "Exchange the pictures of the eyes.");
}

EyesOptions eyesOptions(const CommandLine& commandLine, const std::string& output, bool files) {
    constexpr std::pair<const char*, EyesFrom> kKeeps[] = {{"left", EyesFrom::KeepLeft}};
    commandLine.refuseWithout(output, {"stereo-layout", "stereo-keep", "stereo-swap"},
                              " describes --" + output + ", expected that option with it");
    EyesOptions options;
    const std::size_t layout = commandLine.choice("stereo-layout", layoutNames(files)).value_or(0);
    options.areFiles = layout == static_cast<std::size_t>(kLayouts);
    if (!options.areFiles) options.picture = static_cast<EyesPicture>(layout);
    std::string strength;
    commandLine.take({{"stereo-keep", options.from, kKeeps},
                      {"stereo-swap", options.swapped},
                      {"strength", strength}});
    if (strength != "auto") commandLine.take({{"strength", options.strengthPercent, 0, 100}});
    return options;
}

std::string eyesEnding(const EyesOptions& options) {
    if (options.areFiles) return ".png";
    const std::string tag = nameOf(options.picture).tag;
    return "_" + (tag.empty() ? nameOf(options.picture).option : tag) + ".png";
}

cv::Mat joinedEyes(const StereoPair& eyes, const EyesOptions& options) {
    cv::Mat joined;
    joinEyes(options.swapped ? eyes.right : eyes.left, options.swapped ? eyes.left : eyes.right,
             options.picture, joined);
    return joined;
}

std::string eyesTagAdvice(const std::filesystem::path& file, const EyesOptions& options) {
    if (options.areFiles || hasEyesTag(file, options.picture)) return {};
    const EyesPictureName name = nameOf(options.picture);
    return file.string() + ": many players know that a file is " + name.words +
           " only by its name, as " + file.stem().string() + "_" + name.tag +
           file.extension().string();
}

void tellEyesTag(const std::filesystem::path& file, const EyesOptions& options,
                 const Messages& messages) {
    const std::string advice = eyesTagAdvice(file, options);
    if (!advice.empty()) messages.say(advice);
}

std::pair<int, int> viewsOfEyes(const QuiltLayout& layout) {
    const int last = layout.viewCount - 1;
    const int left = std::min(cvRound(last * 3.0 / 8), (last - 1) / 2); // never the same view
    return {left, last - left};
}

StereoPair eyesOfQuilt(const cv::Mat& quilt, const QuiltLayout& layout, double aspect) {
    const cv::Size tile = layout.tileSize;
    const cv::Size size(std::max(tile.width, cvRound(tile.height * aspect)),
                        std::max(tile.height, cvRound(tile.width / aspect)));
    const auto [left, right] = viewsOfEyes(layout);
    StereoPair eyes;
    for (const auto& [view, picture] : {std::pair(left, &eyes.left), {right, &eyes.right}})
        cv::resize(quilt(layout.tile(view)), *picture, size, 0, 0, cv::INTER_LINEAR);
    return eyes;
}

void EyesFiles::add(CommandLine& commandLine, const std::string& of, bool keep) {
    commandLine.add({"save-stereo"},
                    "Also write a picture for two eyes (headsets, 3D televisions, red-cyan "
                    "glasses). " +
                        of,
                    "FILE");
    addEyesOptions(commandLine, "save-stereo", true, keep);
}

EyesFiles::EyesFiles(const CommandLine& commandLine)
    : options_(eyesOptions(commandLine, "save-stereo", true)) {
    commandLine.take({{"save-stereo", file_}});
}

EyesFiles::EyesFiles(const EyesFiles& same, std::filesystem::path file)
    : options_(same.options_), file_(std::move(file)) {}

std::vector<std::filesystem::path> EyesFiles::files() const {
    if (file_.empty()) return {};
    if (!options_.areFiles) return {file_};
    const auto named = [&](const char* eye) {
        std::filesystem::path file = file_;
        return file.replace_filename(file_.stem().string() + eye + file_.extension().string());
    };
    return {named("_L"), named("_R")};
}

std::string EyesFiles::names() const {
    std::string all;
    for (const std::filesystem::path& file : files())
        all += (all.empty() ? "" : ", ") + file.string();
    return all;
}

void EyesFiles::write(const StereoPair& eyes, Messages& messages) const {
    tellEyesTag(file_, options_, messages);
    if (!options_.areFiles) {
        if (options_.picture >= EyesPicture::Anaglyph) warnAboutEyesFormat(file_, messages);
        return writeEyes(file_, joinedEyes(eyes, options_), options_.picture, options_.swapped);
    }
    writeImage(files()[0], options_.swapped ? eyes.right : eyes.left);
    writeImage(files()[1], options_.swapped ? eyes.left : eyes.right);
}

} // namespace altiro3D::tools
