#include "altiro3D/recipe.hpp"

#include "altiro3D/error.hpp"
#include "base/json_reader.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <type_traits>
#include <utility>

namespace altiro3D {

namespace {

constexpr const char* kAuto = "auto";

// The shortest text that is read as the same number.
std::string exactText(double value) {
    std::string text;
    for (int digits = 6; digits <= 17; ++digits) {
        text = numberText(value, digits);
        if (numberAt(text) == value) break;
    }
    return text;
}

// All of a text as a number in a range.
std::optional<double> numberIn(const std::string& text, double least, double most) {
    const bool isNumber = !text.empty() && text[0] != '+' &&
                          text.find_first_not_of("0123456789.eE+-") == std::string::npos;
    double value = 0;
#ifdef __cpp_lib_to_chars
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool isRead = error == std::errc() && end == text.data() + text.size();
#else // the library of Emscripten, which has one locale
    char* end = nullptr;
    value = std::strtod(text.c_str(), &end);
    const bool isRead = end == text.c_str() + text.size();
#endif
    return isNumber && isRead && value >= least && value <= most ? std::optional<double>(value)
                                                                 : std::nullopt;
}

// A number, or kAuto if it may be chosen. @param access gives the field of a recipe
template <class Access>
RecipeField number(RecipeField field, const Access& access, bool AutoChoices::*chosen = nullptr) {
    using Number = std::decay_t<decltype(access(std::declval<Recipe&>()))>;
    constexpr bool kIsWhole = std::is_integral_v<Number>;
    field.expected = (kIsWhole ? "a whole number " : "a number ") + numberText(field.least) + ".." +
                     numberText(field.most);
    field.text = [access, chosen](const Recipe& recipe) {
        return chosen != nullptr && recipe.choices.*chosen
                   ? kAuto
                   : exactText(static_cast<double>(access(recipe)));
    };
    field.read = [access, chosen, least = field.least, most = field.most](Recipe& recipe,
                                                                          const std::string& text) {
        const bool isChosen = chosen != nullptr && text == kAuto;
        const Recipe standard;
        const auto value =
            isChosen ? static_cast<double>(access(standard)) : numberIn(text, least, most);
        if (!value || (kIsWhole && *value != std::floor(*value))) return false;
        if (chosen != nullptr) recipe.choices.*chosen = isChosen;
        access(recipe) = static_cast<Number>(*value);
        return true;
    };
    return field;
}

template <class Value>
using Words = std::vector<std::pair<const char*, Value>>;

// One of some words. @param access gives the field of a recipe
template <class Value, class Access>
RecipeField oneOf(RecipeField field, const Words<Value>& words, const Access& access) {
    for (const auto& [word, value] : words) {
        const bool isLast = word == words.back().first;
        const bool isFirst = field.expected.empty();
        field.valueName += (isFirst ? "" : "|") + std::string(word);
        field.expected += (isFirst ? "" : isLast ? " or " : ", ") + std::string(word);
    }
    field.text = [words, access](const Recipe& recipe) -> std::string {
        const auto isIt = [&](const auto& word) { return word.second == access(recipe); };
        return std::find_if(words.begin(), words.end(), isIt)->first;
    };
    field.read = [words, access](Recipe& recipe, const std::string& text) {
        const auto isIt = [&](const auto& word) { return word.first == text; };
        const auto found = std::find_if(words.begin(), words.end(), isIt);
        if (found == words.end()) return false;
        access(recipe) = found->second;
        return true;
    };
    return field;
}

// True or false. @param isSet reads it, set writes it
template <class IsSet, class Set>
RecipeField flag(RecipeField field, const IsSet& isSet, const Set& set) {
    field.expected = "true or false";
    field.text = [isSet](const Recipe& recipe) { return isSet(recipe) ? "true" : "false"; };
    field.read = [set](Recipe& recipe, const std::string& text) {
        if (text != "true" && text != "false") return false;
        set(recipe, text == "true");
        return true;
    };
    return field;
}

// The fit, whose word kAuto means that a picture is cut by what it shows.
RecipeField fitField(RecipeField field) {
    RecipeField words = oneOf<FitMode>(
        std::move(field),
        {{"cover", FitMode::Cover},
         {"contain", FitMode::Contain},
         {"stretch", FitMode::Stretch},
         {kAuto, FitMode::Cover}},
        [](auto& r) -> auto& { return r.fit; });
    words.text = [text = words.text](const Recipe& recipe) {
        return recipe.choices.framing ? kAuto : text(recipe);
    };
    words.read = [read = words.read](Recipe& recipe, const std::string& text) {
        if (!read(recipe, text)) return false;
        recipe.choices.framing = text == kAuto;
        return true;
    };
    return words;
}

// The centre of the part that is shown.
RecipeField centreField(RecipeField field) {
    field.most = 1;
    field.expected = "two numbers 0..1 with a comma, such as 0.3,0.5";
    field.text = [](const Recipe& recipe) {
        const cv::Point2d& centre = recipe.framing.centre;
        return exactText(centre.x) + "," + exactText(centre.y);
    };
    field.read = [](Recipe& recipe, const std::string& text) {
        const std::size_t comma = std::min(text.find(','), text.size());
        const auto x = numberIn(text.substr(0, comma), 0, 1);
        const auto y = numberIn(text.substr(std::min(comma + 1, text.size())), 0, 1);
        if (!x || !y) return false;
        recipe.framing.centre = {*x, *y};
        return true;
    };
    return field;
}

std::vector<RecipeField> makeFields() {
    constexpr auto kViews = RecipePart::Views;
    constexpr auto kPlacement = RecipePart::Placement;
    constexpr auto kNative = RecipePart::Native;
    std::vector<RecipeField> fields = {
        oneOf<ViewMethod>(
            {"method", "",
             "How views are made: layered (default), the most accurate; fast, the "
             "published quick method, soft at edges; real, the published geometric "
             "method, slow.",
             kViews},
            {{"layered", ViewMethod::Layered},
             {"fast", ViewMethod::Fast},
             {"real", ViewMethod::Real}},
            [](auto& r) -> auto& { return r.views.method; }),
        number(
            {"strength", "PERCENT",
             "Parallax of the whole depth range between the outermost views, in % of the "
             "picture's width, 0..100",
             kViews, false, 0, 100},
            [](auto& r) -> auto& { return r.views.strengthPercent; }, &AutoChoices::strength),
        flag(
            {"limit-strength", "", "", kViews}, [](const Recipe& r) { return r.choices.limit; },
            [](Recipe& r, bool is) { r.choices.limit = is; }),
        number(
            {"focus", "DEPTH", "Depth that appears on the panel's surface, 0 farthest .. 1 nearest",
             kViews, false, 0, 1},
            [](auto& r) -> auto& { return r.views.focus; }, &AutoChoices::focus),
        number(
            {"depth-curve", "EXPONENT",
             "Exponent of depth, 0.5..2 (default 1): above 1, near things take more of the "
             "depth; below 1, far ones. --focus is a depth after it.",
             kViews, true, 0.5, 2},
            [](auto& r) -> auto& { return r.depthCurve; }),
        flag(
            {"exact-depth", "",
             "Use the depth as it is. By default its edges are moved to the edges of the photo "
             "and soft steps are sharpened; exact depth hardly changes. Videos with estimated "
             "depth and method fast always use it as it is.",
             kViews, true},
            [](const Recipe& r) { return r.refine.keepsDepth(); },
            [](Recipe& r, bool is) {
                r.refine.flaws = is ? std::optional<DepthFlaws>(DepthFlaws()) : std::nullopt;
            }),
        oneOf<LayeredFill>(
            {"fill", "",
             "Layered: fill what was hidden with a painted background (background, "
             "default) or by repeating the border (continue, quicker).",
             kViews, true},
            {{"background", LayeredFill::BackgroundLayer}, {"continue", LayeredFill::Continue}},
            [](auto& r) -> auto& { return r.views.layered.fill; }),
        oneOf<bool>(
            {"borders", "",
             "Layered: split the colours of px at the borders of near things, which also "
             "show what is behind them (soft, default), or not (hard, quicker).",
             kViews, true},
            {{"soft", true}, {"hard", false}},
            [](auto& r) -> auto& { return r.views.layered.softBorders; }),
        number(
            {"refine", "STEPS",
             "Fast: refinement steps, 0..16 (default 0, as published): more accurate, slower.",
             kViews, true, 0, 16},
            [](auto& r) -> auto& { return r.views.refinement; }),
        oneOf<bool>(
            {"inpaint-from", "",
             "Real: paint holes from all pixels around them (around, default, as "
             "published) or only from the background (behind, more accurate, slower).",
             kViews, true},
            {{"around", false}, {"behind", true}},
            [](auto& r) -> auto& { return r.views.real.backgroundOnly; }),
        fitField(
            {"fit", "", "How pictures that do not have the panel's shape are fitted", kPlacement}),
        centreField({"center", "X,Y",
                     "Centre of the part that is shown, in widths and heights of the picture: 0,0 "
                     "is the top left, 1,1 the bottom right (default 0.5,0.5).",
                     kPlacement}),
        number(
            {"zoom", "FACTOR",
             "Show a smaller part of the picture, enlarged, 1..1000 (default 1). With --fit "
             "contain, the bars shrink first.",
             kPlacement, true, 1, 1000},
            [](auto& r) -> auto& { return r.framing.zoom; }),
        oneOf<Detail>(
            {"detail", "", "", kNative},
            {{"view", Detail::View}, {"lens", Detail::Lens}, {"panel", Detail::Panel}},
            [](auto& r) -> auto& { return r.detail; }),
        flag(
            {"lens-filter", "", "", kNative}, [](const Recipe& r) { return r.lensFilter; },
            [](Recipe& r, bool is) { r.lensFilter = is; }),
        oneOf<ViewPositions>(
            {"positions", "", "", kNative},
            {{"discrete", ViewPositions::Discrete}, {"continuous", ViewPositions::Continuous}},
            [](auto& r) -> auto& { return r.positions; }),
        oneOf<ViewFilter>(
            {"view-filter", "", "", kNative},
            {{"nearest", ViewFilter::Nearest}, {"linear", ViewFilter::Linear}},
            [](auto& r) -> auto& { return r.sampling.views; }),
        oneOf<TileSampling>(
            {"sampling", "", "", kNative},
            {{"nearest", TileSampling::Nearest}, {"linear", TileSampling::Linear}},
            [](auto& r) -> auto& { return r.sampling.inTile; })};
    for (auto& field : fields) {
        if (field.name == "fill" || field.name == "borders") field.method = ViewMethod::Layered;
        if (field.name == "refine") field.method = ViewMethod::Fast;
        if (field.name == "inpaint-from") field.method = ViewMethod::Real;
    }
    return fields;
}

} // namespace

const std::vector<RecipeField>& recipeFields() {
    static const std::vector<RecipeField> fields = makeFields();
    return fields;
}

const RecipeField& recipeField(std::string_view name) {
    for (const RecipeField& field : recipeFields())
        if (field.name == name) return field;
    throw Error(ErrorCode::InvalidArgument, std::string(name), "is not a setting of a recipe");
}

std::string recipeText(const Recipe& recipe) {
    Json json = Json::object();
    for (const RecipeField& field : recipeFields()) {
        const std::string text = field.text(recipe);
        const Json value = Json::parse(text, nullptr, false); // of numbers, true and false
        json[field.name] = value.is_discarded() ? Json(text) : value;
    }
    return json.dump();
}

Recipe parseRecipe(const std::string& json, const std::string& source) {
    constexpr const char* kExpected = "the settings of a picture";
    const Json members = parseJson(json, source, kExpected);
    if (!members.is_object())
        throw Error(ErrorCode::BadFormat, source,
                    "holds " + shownJson(members) + ", expected " + kExpected);
    Recipe recipe;
    for (const auto& member : members.items()) {
        const std::string& name = member.key();
        const Json& value = member.value();
        const auto& fields = recipeFields();
        const auto field = std::find_if(fields.begin(), fields.end(),
                                        [&](const RecipeField& it) { return it.name == name; });
        const std::string subject = source + ": " + shortened(name);
        if (field == fields.end())
            throw Error(ErrorCode::BadFormat, subject, "is not a setting of a picture");
        if (!field->read(recipe, value.is_string() ? value.get<std::string>() : value.dump()))
            throw Error(ErrorCode::BadFormat, subject,
                        "is " + shownJson(value) + ", expected " + field->expected);
    }
    return recipe;
}

bool operator==(const Recipe& a, const Recipe& b) {
    return NativeOptions::fields(a) == NativeOptions::fields(b) &&
           AutoChoices::fields(a.choices) == AutoChoices::fields(b.choices);
}

} // namespace altiro3D
