#include "cli/picture_options.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <initializer_list>

namespace altiro3D::tools {

namespace {

constexpr std::pair<const char*, ViewMethod> kMethods[] = {
    {"fast", ViewMethod::Fast}, {"real", ViewMethod::Real}, {"layered", ViewMethod::Layered}};
constexpr std::pair<const char*, FitMode> kFits[] = {
    {"cover", FitMode::Cover}, {"contain", FitMode::Contain}, {"stretch", FitMode::Stretch}};

template <typename Value, std::size_t N>
std::string nameOf(const std::pair<const char*, Value> (&words)[N], Value value) {
    const auto isIt = [&](const auto& word) { return word.second == value; };
    return std::find_if(std::begin(words), std::end(words), isIt)->first;
}

// The method, and the options of each, which are refused for another one.
ViewOptions viewOptions(const CommandLine& commandLine, const AutoChoices& choices,
                        ViewMethod standard) {
    ViewOptions options;
    const ViewOptions usual;
    const auto method = commandLine.oneOf("method", kMethods);
    const bool isGeometric = commandLine.has("g");
    if (isGeometric && method && *method != ViewMethod::Real)
        throw UsageError("-g means --method real, expected no other --method");
    options.method = method.value_or(isGeometric ? ViewMethod::Real : standard);
    if (!choices.strength)
        options.strengthPercent =
            commandLine.number("strength", 0, 100).value_or(usual.strengthPercent);
    if (!choices.focus) options.focus = commandLine.number("focus", 0, 1).value_or(usual.focus);
    options.layered.fill =
        commandLine
            .oneOf<LayeredFill>("fill", {{"background", LayeredFill::BackgroundLayer},
                                         {"continue", LayeredFill::Continue}})
            .value_or(usual.layered.fill);
    options.layered.softBorders = commandLine.choice("borders", {"soft", "hard"}).value_or(0) == 0;
    options.refinement = commandLine.wholeNumber("refine", 0, 16).value_or(usual.refinement);
    options.real.backgroundOnly =
        commandLine.choice("inpaint-from", {"around", "behind"}).value_or(0) == 1;
    return options;
}

// Refuses options of methods that are not used, unless they have their default values.
void requireKnobsOf(const ViewOptions& given) {
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
        if (knob.owner == given.method || !knob.turned) continue;
        throw UsageError("--" + std::string(knob.name) + " is an option of method " +
                         methodName(knob.owner) + ", but " + methodName(given.method) +
                         " is used; expected --method " + methodName(knob.owner));
    }
}

Framing framingOption(const CommandLine& commandLine, FitMode fit, bool isAuto) {
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
        commandLine.failValue("center", "two numbers 0..1 with a comma, such as 0.3,0.5");
    }
    if (isAuto)
        throw UsageError("--fit auto chooses the centre itself, expected no --center with it");
    if (fit != FitMode::Cover && framing.zoom == 1) {
        throw UsageError("--center has no effect, as --fit " + fitName(fit) +
                         " shows all of the picture; expected --fit cover, or --zoom with it");
    }
    return framing;
}

// Refuses what continuous positions rule out.
void requireContinuous(const CommandLine& commandLine, const SceneOptions& options) {
    if (!options.mustBeContinuous) return;
    if (commandLine.has("m")) {
        throw UsageError("--continuous needs the exact directions of the lenses, but a map (-m) "
                         "has whole views only; expected -c instead of -m");
    }
    if (options.native.views.method == ViewMethod::Real) {
        throw UsageError("--continuous reads single sub-pixels, but method real makes whole views "
                         "only; expected --method layered or fast with it");
    }
    if (options.native.sampling.blends()) {
        throw UsageError("--continuous needs no blending: --view-filter and --sampling blend "
                         "views of a quilt; expected it without them");
    }
}

// Whether no option asks for another way than all that the lenses show of a photo.
bool isPlain(const CommandLine& commandLine) {
    const auto others = {"quick",    "m",      "g", "method",    "view-filter",
                         "sampling", "budget", "k", "continuous"};
    return std::none_of(others.begin(), others.end(),
                        [&](const char* option) { return commandLine.has(option); });
}

bool isContinuous(const NativeOptions& options) {
    return options.positions == ViewPositions::Continuous;
}

} // namespace

void addSceneOptions(CommandLine& commandLine, AutoUse use) {
    std::string strength = "10)";
    std::string focus = "0.5).";
    if (use == AutoUse::Photos) {
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

void addDepthCurveOption(CommandLine& commandLine) {
    commandLine.addAdvanced({"depth-curve"},
                            "Exponent of depth, 0.5..2 (default 1): above 1, near things take more "
                            "of the depth; below 1, far ones. --focus is a depth after it.",
                            "EXPONENT");
}

void addRefineOption(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"exact-depth"},
        "Use the depth as it is. By default its edges are moved to the edges of the photo, soft "
        "steps are sharpened; exact depth hardly changes. Videos with "
        "estimated depth and method fast always use it as it is.");
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
    addDepthCurveOption(commandLine);
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
}

void addNativeOptions(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"continuous"},
        "Compute each sub-pixel for the exact direction in which its lens sends it, not for the "
        "nearest view. Not with -g, -m, --view-filter and --sampling.");
}

void addQuickOption(CommandLine& commandLine) {
    commandLine.add({"quick"},
                    "Make views of a quilt's size, each px as it is: detail that the lenses cannot "
                    "show becomes coloured noise. So do --method, -k, --continuous, --sampling, "
                    "--view-filter, --budget and -m.");
}

SceneOptions sceneOptions(const CommandLine& commandLine, AutoUse use, ViewMethod standard) {
    const bool isPhoto = use == AutoUse::Photos;
    const auto has = [&](const char* option) { return commandLine.has(option); };
    const auto isAuto = [&](const char* option) { return commandLine.value(option) == "auto"; };
    SceneOptions options;
    // those that are asked for; photos have more, below
    options.choices = {isAuto("fit"), isAuto("focus"), isAuto("strength")};
    NativeOptions& native = options.native;
    native.views = viewOptions(commandLine, options.choices, standard);
    native.fit = commandLine
                     .oneOf<FitMode>("fit", {{"cover", FitMode::Cover},
                                             {"contain", FitMode::Contain},
                                             {"stretch", FitMode::Stretch},
                                             {"auto", FitMode::Cover}})
                     .value_or(FitMode::Cover);
    native.framing = framingOption(commandLine, native.fit, options.choices.framing);
    if (has("exact-depth")) native.refine.flaws = DepthFlaws();
    native.depthCurve = commandLine.number("depth-curve", 0.5, 2).value_or(1);
    if (has("k")) native.detail = Detail::Panel;
    if (has("continuous")) native.positions = ViewPositions::Continuous;
    if (isPhoto && isPlain(commandLine)) native.showAs(Detail::Lens);
    options.mustBeContinuous = has("continuous");
    native.sampling = samplingOption(commandLine);
    if (isPhoto) {
        options.unasked.framing = !has("fit") && !has("center");
        options.unasked.focus = !has("focus");
        options.choices.framing = options.choices.framing || options.unasked.framing;
        options.choices.focus = options.choices.focus || options.unasked.focus;
        options.choices.limit = !has("strength") && !has("camera");
    }
    requireKnobsOf(native.views);
    requireContinuous(commandLine, options);
    return options;
}

NativeMaker makeNativeMaker(const SceneOptions& asked, const ChosenDisplay& display,
                            const QuiltLayout& layout, Messages& messages, bool preferContinuous) {
    NativeOptions options = asked.native;
    const std::string why =
        display.map ? "a map was given" : NativeMaker::obstacle(layout, options);
    if (isContinuous(options) && !why.empty()) {
        if (asked.mustBeContinuous)
            throw UsageError("--continuous: " + why + ", expected fewer (-q)");
        options.detail = Detail::View; // without what showAs() sets
        options.lensFilter = false;
        options.positions = ViewPositions::Discrete;
    }
    if (why.empty()) {
        if (preferContinuous) options.positions = ViewPositions::Continuous;
        messages.detail("path: direct, " + (isContinuous(options)
                                                ? "continuous positions"
                                                : std::to_string(layout.viewCount) + " positions"));
        return NativeMaker(display, layout, options);
    }
    messages.detail("path: over the quilt, as " + why);
    if (options.sampling.blends() || display.calibration.sheet)
        return NativeMaker(display, layout, options);
    return NativeMaker(lookUpTable(display, layout, messages), options);
}

std::string pathName(const NativeMaker& maker) {
    return maker.path() == NativePath::Direct ? "direct" : "quilt";
}

std::string unaskedText(const AutoChoices& unasked) {
    const bool framing = unasked.framing;
    const bool focus = unasked.focus;
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

std::string methodName(ViewMethod method) {
    return nameOf(kMethods, method);
}

void CameraOptions::add(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"camera"},
        "Real: the camera of the photo and the distances in it, JSON with fx fy cx cy "
        "(px of the photo), zNear zFar baseline (one unit); replaces --strength.",
        "FILE.json");
}

CameraOptions::CameraOptions(const CommandLine& commandLine, ViewMethod method)
    : file_(commandLine.value("camera").value_or("")) {
    commandLine.exclude("camera", "strength");
    if (file_.empty()) return;
    camera_ = readCamera(file_);
    if (method != ViewMethod::Real)
        throw UsageError("--camera is an option of method real, expected -g with it");
}

Camera CameraOptions::fittedCamera(const PhotoFit& fit) const {
    Camera camera = *camera_;
    camera.intrinsics = fitted(camera.intrinsics, fit.source, fit.target.size());
    return camera;
}

std::optional<double> CameraOptions::strength(const PhotoFit& fit) const {
    if (!camera_) return {};
    return 100 * parallaxOf(fittedCamera(fit)) / fit.size.width;
}

ViewOptions CameraOptions::apply(ViewOptions options, const PhotoFit& fit,
                                 Messages& messages) const {
    if (!camera_) return options;
    options.strengthPercent = *strength(fit);
    messages.detail("camera: " + file_.string() + ", " +
                    std::to_string(fittedCamera(fit).intrinsics.fx) + " px in the view");
    return options;
}

void addFitOption(CommandLine& commandLine, const std::string& standard) {
    commandLine.add(
        {"fit"},
        "Pictures of another shape than the panel's: cover, contain or stretch (default " +
            standard + ").",
        "cover|contain|stretch");
}

void addPhotoFitOptions(CommandLine& commandLine, AutoUse use) {
    const bool isDefault = use == AutoUse::Photos;
    commandLine.add(
        {"fit"},
        std::string("Pictures of another shape than the panel's: cover") +
            (isDefault ? "" : " (default)") + ", contain, stretch, or auto" +
            (isDefault ? " (default): cover that keeps what is near and sharp, and enlarges by up "
                         "to 5 % so that no view looks beyond the photo."
                       : ": cover that keeps what is near and sharp."),
        "cover|contain|stretch|auto");
    commandLine.add({"center"},
                    "Centre of the part that is shown, in widths and heights of the picture: 0,0 "
                    "is the top left, 1,1 the bottom right (default 0.5,0.5).",
                    "X,Y");
    commandLine.addAdvanced(
        {"zoom"},
        "Show a smaller part of the picture, enlarged, 1..1000 (default 1). With "
        "--fit contain, the bars shrink first.",
        "FACTOR");
}

std::optional<FitMode> fitOption(const CommandLine& commandLine) {
    return commandLine.oneOf("fit", kFits);
}

std::string fitName(FitMode mode) {
    return nameOf(kFits, mode);
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

void warnAboutParallax(const AdjacentParallax& parallax, Messages& messages,
                       const std::string& remedy) {
    if (!(parallax.viewPixels > kParallaxBudgetPixels)) return;
    messages.warnOfSubject("parallax between adjacent views is up to " +
                           fixed(parallax.viewPixels, 1) + " view px, above " +
                           fixed(kParallaxBudgetPixels, 0) +
                           ": hard edges will show double; lower " + remedy + " or move --focus");
}

} // namespace altiro3D::tools
