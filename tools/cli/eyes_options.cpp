#include "cli/eyes_options.hpp"

#include <string>
#include <vector>

namespace altiro3D::tools {

namespace {

constexpr int kLayouts = static_cast<int>(EyesPicture::Rows) + 1;

} // namespace

void addEyesOptions(CommandLine& commandLine, const std::string& output, bool files) {
    std::string names;
    for (int i = 0; i < kLayouts; ++i)
        names += (i == 0 ? "" : "|") + std::string(nameOf(static_cast<EyesPicture>(i)).option);
    commandLine.add({"stereo-layout"},
                    "Layout of --" + output +
                        ": side by side (sbs, default), crossed eyes, top and bottom (tb), for "
                        "red-cyan glasses (anaglyph), or rows of a television with polarized ones; "
                        "-half: each eye squeezed to half, or half the colour." +
                        (files ? " files: two pictures, FILE_L and FILE_R." : ""),
                    names + (files ? "|files" : ""));
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
    std::vector<std::string> names;
    for (int i = 0; i < kLayouts; ++i)
        names.emplace_back(nameOf(static_cast<EyesPicture>(i)).option);
    names.emplace_back("files");
    EyesOptions options;
    const std::size_t layout = commandLine.choice("stereo-layout", names).value_or(0);
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

} // namespace altiro3D::tools
