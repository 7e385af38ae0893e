#include "cli/picture_options.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>

namespace altiro3D::tools {

namespace {

// Ends the help of a field: its default, and what "auto" does.
std::string defaultText(const std::string& field, AutoUse use) {
    const bool isPhoto = use == AutoUse::Photos;
    if (field == "fit")
        return std::string(": cover") + (isPhoto ? "" : " (default)") +
               ", contain, stretch, or auto" +
               (isPhoto ? " (default): cover that keeps what is near and sharp, and enlarges by up "
                          "to 5 % so that no view looks beyond the photo."
                        : ": cover that keeps what is near and sharp.");
    if (field == "focus")
        return isPhoto                 ? " (default auto, the depth of the subject)."
               : use == AutoUse::Named ? " (default 0.5); auto: the depth of the subject."
                                       : " (default 0.5).";
    if (field != "strength") return {};
    return std::string(" (default 10") +
           (isPhoto ? ", of estimated depth less where views would show much that the photo does "
                      "not)"
                    : ")") +
           (use == AutoUse::None ? "."
                                 : "; auto: as much as the display shows without double edges and "
                                   "the scene allows, at most 12.");
}

// Refuses options of methods that are not used, unless they have their default values.
void requireFieldsOfMethod(const Recipe& given) {
    for (const RecipeField& field : recipeFields()) {
        if (field.method.value_or(given.views.method) == given.views.method ||
            field.text(given) == field.text(Recipe()))
            continue;
        const std::string owner = methodName(*field.method);
        throw UsageError("--" + field.name + " is an option of method " + owner + ", but " +
                         methodName(given.views.method) + " is used; expected --method " + owner);
    }
}

// Refuses a centre that has no effect.
void requireCentre(const CommandLine& commandLine, const Recipe& recipe) {
    if (!commandLine.has("center")) return;
    if (recipe.choices.framing)
        throw UsageError("--fit auto chooses the centre itself, expected no --center with it");
    if (recipe.fit != FitMode::Cover && recipe.framing.zoom == 1) {
        throw UsageError("--center has no effect, as --fit " + fitName(recipe.fit) +
                         " shows all of the picture; expected --fit cover, or --zoom with it");
    }
}

// Refuses what continuous positions rule out.
void requireContinuous(const CommandLine& commandLine, const SceneOptions& options) {
    if (!options.mustBeContinuous) return;
    if (commandLine.has("m")) {
        throw UsageError("--continuous needs the exact directions of the lenses, but a map (-m) "
                         "has whole views only; expected -c instead of -m");
    }
    if (options.recipe.views.method == ViewMethod::Real) {
        throw UsageError("--continuous reads single sub-pixels, but method real makes whole views "
                         "only; expected --method layered or fast with it");
    }
    if (options.recipe.sampling.blends()) {
        throw UsageError("--continuous needs no blending: --view-filter and --sampling blend "
                         "views of a quilt; expected it without them");
    }
}

// Whether no option asks for another way to show a photo than showAs(Detail::Lens).
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

void addField(CommandLine& commandLine, const std::string& name, AutoUse use) {
    const RecipeField& field = recipeField(name);
    const std::string help = field.help + defaultText(name, use);
    if (field.isRare) {
        commandLine.addAdvanced({name}, help, field.valueName);
    } else {
        commandLine.add({name}, help, field.valueName);
    }
}

void addFields(CommandLine& commandLine, RecipePart part, AutoUse use) {
    for (const RecipeField& field : recipeFields()) {
        if (field.part != part || field.help.empty()) continue;
        addField(commandLine, field.name, use);
        if (field.name == "method")
            commandLine.addAdvanced({"g", "geometric"}, "The same as --method real.");
        if (field.name == "exact-depth")
            commandLine.addAdvanced(
                {"k", "keep"},
                "Compute views at the panel's resolution: more detail, more time. Only a Native "
                "that is made without a quilt keeps all of the detail.");
    }
}

void addNativeOptions(CommandLine& commandLine) {
    commandLine.addAdvanced(
        {"continuous"},
        "Compute each sub-pixel for the exact direction in which its lens sends it, not for the "
        "nearest view. Not with -g, -m, --view-filter and --sampling.");
}

void addQuickOption(CommandLine& commandLine) {
    commandLine.add({"quick"},
                    "Make views of a quilt's size, and keep each px as it is: detail that the "
                    "lenses cannot show becomes coloured noise. --method, -k, --continuous, "
                    "--sampling, --view-filter, --budget and -m also keep each px as it is.");
}

void readFields(const CommandLine& commandLine, Recipe& recipe) {
    for (const RecipeField& field : recipeFields()) {
        if (!commandLine.has(field.name)) continue;
        const bool isFlag = field.valueName.empty();
        if (!field.read(recipe, isFlag ? "true" : *commandLine.value(field.name)))
            commandLine.failValue(field.name, field.expected);
    }
}

SceneOptions sceneOptions(const CommandLine& commandLine, AutoUse use, ViewMethod standard) {
    const bool isPhoto = use == AutoUse::Photos;
    const auto has = [&](const char* option) { return commandLine.has(option); };
    SceneOptions options;
    Recipe& recipe = options.recipe;
    recipe.views.method = has("g") ? ViewMethod::Real : standard;
    readFields(commandLine, recipe);
    if (has("g") && recipe.views.method != ViewMethod::Real)
        throw UsageError("-g means --method real, expected no other --method");
    requireCentre(commandLine, recipe);
    if (has("k")) recipe.detail = Detail::Panel;
    if (has("continuous")) recipe.positions = ViewPositions::Continuous;
    if (isPhoto && isPlain(commandLine)) recipe.showAs(Detail::Lens);
    options.mustBeContinuous = has("continuous");
    if (isPhoto) {
        options.unasked.framing = !has("fit") && !has("center");
        options.unasked.focus = !has("focus");
        recipe.choices.framing = recipe.choices.framing || options.unasked.framing;
        recipe.choices.focus = recipe.choices.focus || options.unasked.focus;
        recipe.choices.limit = !has("strength") && !has("camera");
    }
    requireFieldsOfMethod(recipe);
    requireContinuous(commandLine, options);
    return options;
}

NativeMaker makeNativeMaker(const SceneOptions& asked, const ChosenDisplay& display,
                            const QuiltLayout& layout, Messages& messages, bool preferContinuous) {
    NativeOptions options = static_cast<const NativeOptions&>(asked.recipe);
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
    if (!display.map || options.sampling.blends() || display.calibration.sheet)
        return NativeMaker(display, layout, options);
    return NativeMaker(*display.map, options);
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
    Recipe recipe;
    recipe.views.method = method;
    return recipeField("method").text(recipe);
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
        "How pictures that do not have the panel's shape are fitted: cover, contain or stretch "
        "(default " +
            standard + ").",
        "cover|contain|stretch");
}

std::optional<FitMode> fitOption(const CommandLine& commandLine) {
    if (!commandLine.has("fit")) return std::nullopt;
    Recipe recipe;
    if (!recipeField("fit").read(recipe, *commandLine.value("fit")) || recipe.choices.framing)
        commandLine.failValue("fit", "cover, contain or stretch");
    return recipe.fit;
}

std::string fitName(FitMode mode) {
    Recipe recipe;
    recipe.fit = mode;
    return recipeField("fit").text(recipe);
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
