#include "cli/eyes_options.hpp"

#include "cli/outputs.hpp"

#include <opencv2/core.hpp>
#include <string>
#include <utility>
#include <vector>

namespace altiro3D::tools {

namespace {

constexpr int kLayouts = static_cast<int>(EyesPicture::Rows) + 1;

// As EyesPicture, and then "files".
std::vector<std::string> layoutNames() {
    std::vector<std::string> names;
    for (int i = 0; i < kLayouts; ++i)
        names.emplace_back(nameOf(static_cast<EyesPicture>(i)).option);
    names.emplace_back("files");
    return names;
}

} // namespace

void addEyesOptions(CommandLine& commandLine, const std::string& output, bool files) {
    commandLine.addAdvanced(
        {"stereo-layout"},
        "Layout of --" + output +
            ": sbs (side by side, default), sbs-half, cross (crossed eyes), tb (top and bottom), "
            "tb-half, anaglyph (red-cyan glasses), anaglyph-half, anaglyph-grey" +
            (files ? ", " : " or ") + "rows (of a television with polarized rows)" +
            (files ? ", or files: two pictures, FILE_L and FILE_R" : "") +
            ". Each eye of sbs-half and tb-half is squeezed to half.",
        "LAYOUT", [files] {
            std::vector<std::string> names = layoutNames();
            if (!files) names.pop_back();
            return names;
        });
    commandLine.addAdvanced({"stereo-keep"},
                            "left: the left eye sees the photo itself, and only the right one's "
                            "picture is made. By default the photo lies between both.",
                            "left");
    commandLine.addAdvanced({"stereo-swap"}, "Exchange the pictures of the eyes.");
}

EyesOptions eyesOptions(const CommandLine& commandLine, const std::string& output) {
    if (!commandLine.has(output)) {
        commandLine.refuse({"stereo-layout", "stereo-keep", "stereo-swap"},
                           " describes --" + output + ", expected that option with it");
    }
    EyesOptions options;
    const std::size_t layout = commandLine.choice("stereo-layout", layoutNames()).value_or(0);
    options.areFiles = layout == static_cast<std::size_t>(kLayouts);
    if (!options.areFiles) options.picture = static_cast<EyesPicture>(layout);
    if (commandLine.choice("stereo-keep", {"left"})) options.from = EyesFrom::KeepLeft;
    options.swapped = commandLine.has("stereo-swap");
    if (commandLine.has("strength") && commandLine.value("strength") != "auto")
        options.strengthPercent = commandLine.number("strength", 0, 100).value_or(kEyesStrength);
    return options;
}

void tellEyesTag(const std::filesystem::path& file, const EyesOptions& options,
                 const Messages& messages) {
    if (options.areFiles || hasEyesTag(file, options.picture)) return;
    const EyesPictureName name = nameOf(options.picture);
    messages.say(file.string() + ": many players know that a file is " + name.words +
                 " only by its name, as " + file.stem().string() + "_" + name.tag +
                 file.extension().string());
}

void EyesFiles::add(CommandLine& commandLine, const std::string& of) {
    commandLine.add({"save-stereo"},
                    "Also write a picture for two eyes (headsets, 3D televisions, red-cyan "
                    "glasses). " +
                        of,
                    "FILE");
    addEyesOptions(commandLine, "save-stereo", true);
}

EyesFiles::EyesFiles(const CommandLine& commandLine)
    : options_(eyesOptions(commandLine, "save-stereo")),
      file_(commandLine.value("save-stereo").value_or("")) {}

EyesFiles::EyesFiles(const EyesFiles& same, std::filesystem::path file)
    : options_(same.options_), file_(std::move(file)) {}

std::string EyesFiles::ending() const {
    if (options_.areFiles) return ".png";
    const std::string tag = nameOf(options_.picture).tag;
    return "_" + (tag.empty() ? nameOf(options_.picture).option : tag) + ".png";
}

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
    const cv::Mat& left = options_.swapped ? eyes.right : eyes.left;
    const cv::Mat& right = options_.swapped ? eyes.left : eyes.right;
    tellEyesTag(file_, options_, messages);
    if (options_.areFiles) {
        writeImage(files()[0], left);
        writeImage(files()[1], right);
        return;
    }
    cv::Mat joined;
    joinEyes(left, right, options_.picture, joined);
    writeImage(file_, joined);
}

} // namespace altiro3D::tools
