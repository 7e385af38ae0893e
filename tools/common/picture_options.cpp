#include "common/picture_options.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>

namespace altiro3D::tools {

namespace {

using Extensions = std::initializer_list<const char*>;

constexpr Extensions kLossyFormats = {".jpg", ".jpeg", ".jpe", ".jp2"};
constexpr Extensions kEightBitFormats = {".webp", ".bmp", ".dib"};

bool hasExtension(const std::filesystem::path& file, Extensions extensions) {
    const std::string extension = lowerCase(file.extension().string());
    return std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

} // namespace

void addSceneOptions(CommandLine& commandLine, AutoUse use) {
    std::string strength = "10)";
    std::string focus = "0.5).";
    if (use == AutoUse::Default) {
        strength = "10, of estimated depth less where views would show much that the photo does "
                   "not)";
        focus = "auto, the depth of the subject).";
    } else if (use == AutoUse::Named) {
        focus = "0.5); auto: the depth of the subject.";
    }
    strength += use == AutoUse::None ? "."
                                     : "; auto: as much as the display shows without double "
                                       "edges and the scene bears, at most 12.";
    commandLine.add(
        {"strength"},
        "Parallax of the whole depth range between the outermost views, in % of the picture's "
        "width, 0..100 (default " +
            strength,
        "PERCENT");
    commandLine.add({"focus"},
                    "Depth that appears on the panel's surface, 0 farthest .. 1 nearest (default " +
                        focus,
                    "DEPTH");
}

void addRefineOption(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"exact-depth"},
        "Use the depth as it is. By default its edges are moved to the edges of the photo, soft "
        "steps are sharpened; exact depth hardly changes. Videos with "
        "estimated depth and method fast always use it as it is.");
}

DepthRefineOptions refineOptions(const CommandLine& commandLine) {
    DepthRefineOptions options;
    if (commandLine.has("exact-depth")) options.flaws = DepthFlaws();
    return options;
}

void addViewOptions(CommandLine& commandLine, AutoUse use) {
    commandLine.addSection("Views");
    commandLine.add(
        {"method"},
        "How views are made: layered (default), the most accurate; fast, the published quick "
        "method, soft at edges; real, the published geometric method, slow.",
        "layered|fast|real");
    commandLine.addAdvanced({"g", "geometric"}, "The same as --method real.");
    addSceneOptions(commandLine, use);
    addRefineOption(commandLine);
    commandLine.addAdvanced(
        {"k", "keep"},
        "Compute views at the panel's resolution: more detail, more time. Only a Native that is "
        "made without a quilt keeps all of the detail.");
    commandLine.addAdvanced({"fill"},
                            "Layered: fill what was hidden with a painted background (background, "
                            "default) or by repeating the border (continue, quicker).",
                            "background|continue");
    commandLine.addAdvanced(
        {"borders"},
        "Layered: split the colours of px at the borders of near things, which also show what is "
        "behind them (soft, default), or not (hard, quicker).",
        "soft|hard");
    commandLine.addAdvanced(
        {"refine"},
        "Fast: refinement steps, 0..16 (default 0, as published): more accurate, slower.", "STEPS");
    commandLine.addAdvanced(
        {"inpaint-from"},
        "Real: paint holes from all pixels around them (around, default, as published) or only "
        "from the background (behind, more accurate, slower).",
        "around|behind");
    commandLine.addDropped("dilate", "1 px is the most accurate, more and less lose detail", "PX");
    commandLine.addDropped("soft-edges", "depth is refined before the views are made", "PX");
    commandLine.addDropped("inpaint", "telea is used, ns took as long and hardly differed",
                           "telea|ns");
}

AutoChoices autoChoices(const CommandLine& commandLine) {
    const auto isAuto = [&](const char* option) { return commandLine.value(option) == "auto"; };
    return {isAuto("fit"), isAuto("focus"), isAuto("strength")};
}

AutoChoices photoChoices(const CommandLine& commandLine) {
    AutoChoices choices = autoChoices(commandLine);
    choices.framing = choices.framing || !(commandLine.has("fit") || commandLine.has("center"));
    choices.focus = choices.focus || !commandLine.has("focus");
    choices.limit = !commandLine.has("strength") && !commandLine.has("camera");
    return choices;
}

std::string fixedWayText(const CommandLine& commandLine, const AutoChoices& choices) {
    const bool framing = choices.framing && !commandLine.has("fit");
    const bool focus = choices.focus && !commandLine.has("focus");
    if (!framing && !focus) return {};
    return std::string("auto: ") + (framing ? "framing" : "") + (framing && focus ? " and " : "") +
           (focus ? "focus" : "") + " by the photo;" + (framing ? " --fit cover" : "") +
           (focus ? " --focus 0.5" : "") + " chooses nothing";
}

std::string autoText(const AutoChoices& choices, const Framing& framing, const ViewOptions& views) {
    std::string text;
    const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
    if (choices.framing)
        add("center " + fixed(framing.centre.x, 2) + "," + fixed(framing.centre.y, 2));
    if (choices.framing && framing.zoom > 1) add("zoom " + fixed(framing.zoom, 2));
    if (choices.focus) add("focus " + fixed(views.focus, 2));
    const bool isLimited = choices.limit && views.strengthPercent < ViewOptions().strengthPercent;
    if (choices.strength || isLimited) add("strength " + fixed(views.strengthPercent, 1) + " %");
    return text;
}

ViewOptions viewOptions(const CommandLine& commandLine) {
    ViewOptions options;
    constexpr ViewMethod kMethods[] = {ViewMethod::Fast, ViewMethod::Real, ViewMethod::Layered};
    const auto method = commandLine.choice("method", {"fast", "real", "layered"});
    if (method) options.method = kMethods[*method];
    if (commandLine.has("g")) {
        if (method && options.method != ViewMethod::Real) {
            throw UsageError("-g means --method real, expected no other --method");
        }
        options.method = ViewMethod::Real;
    }
    const AutoChoices choices = autoChoices(commandLine);
    if (!choices.strength) {
        options.strengthPercent =
            commandLine.number("strength", 0, 100).value_or(options.strengthPercent);
    }
    if (!choices.focus) options.focus = commandLine.number("focus", 0, 1).value_or(options.focus);
    if (commandLine.choice("fill", {"background", "continue"}).value_or(0) == 1) {
        options.layered.fill = LayeredFill::Continue;
    }
    options.layered.softBorders = commandLine.choice("borders", {"soft", "hard"}).value_or(0) == 0;
    options.refinement = commandLine.wholeNumber("refine", 0, 16).value_or(options.refinement);
    options.real.backgroundOnly =
        commandLine.choice("inpaint-from", {"around", "behind"}).value_or(0) == 1;
    return options;
}

std::string methodName(ViewMethod method) {
    switch (method) {
    case ViewMethod::Fast:
        return "fast";
    case ViewMethod::Real:
        return "real";
    case ViewMethod::Layered:
        break;
    }
    return "layered";
}

void requireKnobsOf(const CommandLine& commandLine, ViewMethod method) {
    const ViewOptions given = viewOptions(commandLine);
    const ViewOptions usual;
    struct Knob {
        const char* name;
        ViewMethod owner;
        bool turned;
    };
    const Knob knobs[] = {
        {"fill", ViewMethod::Layered, given.layered.fill != usual.layered.fill},
        {"borders", ViewMethod::Layered, given.layered.softBorders != usual.layered.softBorders},
        {"refine", ViewMethod::Fast, given.refinement != usual.refinement},
        {"inpaint-from", ViewMethod::Real, given.real.backgroundOnly != usual.real.backgroundOnly}};
    for (const Knob& knob : knobs) {
        if (knob.owner == method || !knob.turned) continue;
        throw UsageError("--" + std::string(knob.name) + " is an option of method " +
                         methodName(knob.owner) + ", but " + methodName(method) +
                         " is used; expected --method " + methodName(knob.owner));
    }
}

void CameraOptions::add(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"camera"},
        "Real: the camera of the photo and the distances in it, JSON with fx fy cx cy "
        "(px of the photo), zNear zFar baseline (one unit); replaces --strength.",
        "FILE.json");
    commandLine.addDropped("fov", "the views depend on --strength alone", "DEGREES");
}

CameraOptions::CameraOptions(const CommandLine& commandLine) {
    commandLine.exclude("camera", "strength");
    if (const auto file = commandLine.value("camera")) {
        camera_ = readCamera(*file);
        source_ = *file;
    }
    if (camera_ && viewOptions(commandLine).method != ViewMethod::Real)
        throw UsageError("--camera is an option of method real, expected -g with it");
}

Camera CameraOptions::fittedCamera(const PhotoFit& fit) const {
    Camera camera = *camera_;
    camera.intrinsics = fitted(camera.intrinsics, fit.source, fit.target.size());
    return camera;
}

std::optional<double> CameraOptions::strength(const ViewOptions& options,
                                              const PhotoFit& fit) const {
    if (!camera_ || options.method != ViewMethod::Real) return {};
    return 100 * parallaxOf(fittedCamera(fit)) / fit.size.width;
}

ViewOptions CameraOptions::apply(const ViewOptions& options, const std::filesystem::path& photoFile,
                                 cv::Size photoSize, const PhotoFit& fit,
                                 Messages& messages) const {
    if (options.method != ViewMethod::Real) return options;
    ViewOptions result = options;
    if (camera_) {
        result.strengthPercent = *strength(options, fit);
        messages.detail("camera: " + source_ + ", " +
                        std::to_string(fittedCamera(fit).intrinsics.fx) + " px in the view");
        return result;
    }
    // Distances are relative: the nearest is 1, the farthest infinity; the baseline follows.
    std::string source = "40 degrees field of view";
    double focalLength = focalLengthFromFieldOfView(photoSize.width, kDefaultFieldOfViewDegrees);
    const double equivalent = readFocalLength35mm(photoFile);
    if (equivalent >= 1 && equivalent <= 10000) {
        focalLength = focalLengthFrom35mm(photoSize, equivalent);
        source = "EXIF";
    }
    Camera camera;
    camera.intrinsics =
        fitted(centredIntrinsics(photoSize, focalLength), fit.source, fit.target.size());
    camera.baseline = baselineFor(camera, options.strengthPercent / 100 * fit.size.width);
    messages.detail("camera: focal length " + std::to_string(focalLength) + " px (" + source +
                    "), baseline " + std::to_string(camera.baseline) +
                    " of the nearest distance to either side");
    return result;
}

void addFitOption(CommandLine& commandLine, const std::string& standard) {
    commandLine.add(
        {"fit"},
        "Pictures of another shape than the panel's: cover, contain or stretch (default " +
            standard + ").",
        "cover|contain|stretch");
}

void addPhotoFitOptions(CommandLine& commandLine, AutoUse use) {
    const bool isDefault = use == AutoUse::Default;
    commandLine.add(
        {"fit"},
        std::string("Pictures of another shape than the panel's: cover") +
            (isDefault ? "" : " (default)") + ", contain, stretch, or auto" +
            (isDefault ? " (default): cover that keeps what is near and sharp, and enlarges by up "
                         "to 5 % so that no view looks beyond the photo."
                       : ": cover that keeps what is near and sharp."),
        "cover|contain|stretch|auto");
    addFramingOptions(commandLine);
}

FitMode photoFitOption(const CommandLine& commandLine) {
    constexpr FitMode kModes[] = {FitMode::Cover, FitMode::Contain, FitMode::Stretch,
                                  FitMode::Cover};
    return kModes[commandLine.choice("fit", {"cover", "contain", "stretch", "auto"}).value_or(0)];
}

std::optional<FitMode> fitOption(const CommandLine& commandLine) {
    constexpr FitMode kModes[] = {FitMode::Cover, FitMode::Contain, FitMode::Stretch};
    const auto choice = commandLine.choice("fit", {"cover", "contain", "stretch"});
    if (!choice) return std::nullopt;
    return kModes[*choice];
}

FitMode fitOption(const CommandLine& commandLine, FitMode standard) {
    return fitOption(commandLine).value_or(standard);
}

void addFramingOptions(CommandLine& commandLine) {
    commandLine.add({"center"},
                    "Centre of the part that is shown, in widths and heights of the picture: 0,0 "
                    "is the top left, 1,1 the bottom right (default 0.5,0.5).",
                    "X,Y");
    commandLine.add({"zoom"},
                    "Show a smaller part of the picture, enlarged, 1..1000 (default 1). With "
                    "--fit contain, the bars shrink first.",
                    "FACTOR");
}

Framing framingOption(const CommandLine& commandLine, FitMode fit) {
    Framing framing;
    framing.zoom = commandLine.number("zoom", 1, 1000).value_or(1);
    const auto centre = commandLine.value("center");
    if (!centre) return framing;
    const char* at = centre->data();
    const char* const end = at + centre->size();
    const auto read = [&](double& part) {
        const auto parsed = std::from_chars(at, end, part);
        at = parsed.ptr;
        return parsed.ec == std::errc() && part >= 0 && part <= 1;
    };
    const auto skipComma = [&] { return at != end && *at++ == ','; };
    if (!read(framing.centre.x) || !skipComma() || !read(framing.centre.y) || at != end) {
        throw UsageError("--center is \"" + *centre +
                         "\", expected two numbers 0..1 with a comma, such as 0.3,0.5");
    }
    if (autoChoices(commandLine).framing)
        throw UsageError("--fit auto chooses the centre itself, expected no --center with it");
    if (fit != FitMode::Cover && framing.zoom == 1) {
        throw UsageError("--center has no effect, as --fit " + fitName(fit) +
                         " shows all of the picture; expected --fit cover, or --zoom with it");
    }
    return framing;
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

std::string cutText(double seenAspect, double panelAspect, FitMode mode) {
    constexpr double kWorthALine = 1.0 / 3;
    const double ratio = seenAspect / panelAspect;
    const double cut = 1 - std::min(ratio, 1 / ratio);
    if (mode != FitMode::Cover || cut < kWorthALine) return {};
    return std::to_string(std::lround(100 * cut)) + " % of the " +
           (ratio > 1 ? "width" : "height") + " is cut off";
}

void tellCut(double seenAspect, double panelAspect, const NativeOptions& options,
             const Messages& messages) {
    const std::string cut = cutText(seenAspect, panelAspect, options.fit);
    if (cut.empty() || options.framing.zoom > 1) return;
    const bool isChosen = options.framing != Framing();
    messages.say("fit: " + cut + " to fill the panel; " +
                 (isChosen ? "" : "--center chooses the part, ") + "--fit contain keeps all of it");
}

void warnAboutParallax(const CommandLine& commandLine, const AdjacentParallax& parallax,
                       Messages& messages) {
    if (!(parallax.viewPixels > kParallaxBudgetPixels)) return;
    messages.warnOfSubject("parallax between adjacent views is up to " +
                           fixed(parallax.viewPixels, 1) + " view px, above " +
                           fixed(kParallaxBudgetPixels, 0) +
                           ": hard edges will show double; lower " +
                           (commandLine.has("camera") ? "the baseline in --camera" : "--strength") +
                           " or move --focus");
}

void warnAboutNativeFormat(const std::filesystem::path& file, Messages& messages) {
    if (hasExtension(file, kLossyFormats)) {
        messages.warn(file.string() +
                      ": this format mixes neighbouring sub-pixels, which belong to different "
                      "views, and weakens the depth; use PNG");
    }
}

void warnAboutDepthFormat(const std::filesystem::path& file, Messages& messages) {
    if (hasExtension(file, kLossyFormats)) {
        messages.warn(file.string() + ": this format changes depth, most of all at its "
                                      "edges; PNG keeps all 16 bits");
    } else if (hasExtension(file, kEightBitFormats)) {
        messages.warn(file.string() +
                      ": this format keeps 8 of the depth's 16 bits; PNG keeps them all");
    }
}

void makeNativeFile(const Quilt2Native& renderer, const cv::Mat& quilt,
                    const std::filesystem::path& output, Messages& messages, StageTimes& times) {
    cv::Mat native;
    renderer.render(quilt, native);
    times.end("render");
    warnAboutNativeFormat(output, messages);
    writeImage(output, native, ImageMark::Native);
    times.end("write");
    messages.say(output.string() + ": Native, " + sizeText(native.size()));
}

void warnIfQuilt(const std::filesystem::path& file, const std::string& instead,
                 Messages& messages) {
    try {
        const std::optional<QuiltName> name = parseQuiltName(file);
        if (!name || name->grid.columns * name->grid.rows < 2) return;
    } catch (const Error&) {
        return; // no quilt's name
    }
    messages.warn(file.string() +
                  ": its name says that it is a quilt, but it is read as one "
                  "picture of a scene; for a quilt use " +
                  instead);
}

void refuseNative(const std::filesystem::path& file, const std::string& expected) {
    if (!isMarkedNative(file)) return;
    throw Error(ErrorCode::BadFormat, file.string(),
                "is a Native already, expected " + expected +
                    " (inputs come first, then outputs; "
                    "native2view shows the views of a Native)");
}

cv::Mat readPhotoFile(const std::filesystem::path& file, Messages& messages) {
    Notes notes;
    cv::Mat photo;
    {
        const QuietStandardError quiet;
        photo = readPhoto(file, &notes);
    }
    for (const Note& note : notes)
        messages.warn(file.string() + ": " + note.text);
    return photo;
}

} // namespace altiro3D::tools
