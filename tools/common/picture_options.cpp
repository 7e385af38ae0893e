#include "common/picture_options.hpp"

#include "altiro3D/image_io.hpp"

#include <algorithm>
#include <cctype>

namespace altiro3D::tools {

void addViewOptions(CommandLine& commandLine) {
    commandLine.addSection("Views");
    commandLine.add({"strength"},
                    "Parallax of the whole depth range between the outermost views, in % of the "
                    "picture's width, 0..100 (default 10).",
                    "PERCENT");
    commandLine.add({"focus"},
                    "Depth that appears on the panel's surface, 0 farthest .. 1 nearest (default "
                    "0.5).",
                    "DEPTH");
    commandLine.add({"k", "keep"},
                    "Make the views at the panel's resolution and average them into the quilt: "
                    "cleaner detail, more work.");
}

ViewOptions viewOptions(const CommandLine& commandLine) {
    ViewOptions options;
    options.strengthPercent =
        commandLine.number("strength", 0, 100).value_or(options.strengthPercent);
    options.focus = commandLine.number("focus", 0, 1).value_or(options.focus);
    return options;
}

void addFitOption(CommandLine& commandLine, const std::string& standard) {
    commandLine.add({"fit"},
                    "Pictures of another shape than the panel's: cover (cut off what is over), "
                    "contain (black bars) or stretch (default " +
                        standard + ").",
                    "MODE");
}

FitMode fitOption(const CommandLine& commandLine, FitMode standard) {
    constexpr FitMode kModes[] = {FitMode::Cover, FitMode::Contain, FitMode::Stretch};
    const auto choice = commandLine.choice("fit", {"cover", "contain", "stretch"});
    return choice ? kModes[*choice] : standard;
}

std::string fitName(FitMode mode) {
    switch (mode) {
    case FitMode::Cover:
        return "cover";
    case FitMode::Contain:
        return "contain";
    case FitMode::Stretch:
        break;
    }
    return "stretch";
}

void warnAboutNativeFormat(const std::filesystem::path& file, Messages& messages) {
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    if (extension == ".jpg" || extension == ".jpeg" || extension == ".jpe" ||
        extension == ".webp" || extension == ".jp2") {
        messages.warn(file.string() +
                      ": this format mixes neighbouring sub-pixels, which belong to different "
                      "views, and depth suffers; PNG keeps a Native as it is");
    }
}

cv::Mat readPhotoFile(const std::filesystem::path& file, Messages& messages) {
    Notes notes;
    cv::Mat photo;
    {
        const QuietStandardError quiet;
        photo = readPhoto(file, &notes);
    }
    for (const std::string& note : notes)
        messages.warn(file.string() + ": " + note);
    return photo;
}

} // namespace altiro3D::tools
