#pragma once

#include "altiro3D/export.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/placement.hpp"
#include "altiro3D/view_options.hpp"

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

/// All settings of a picture: how its views and its Native are made, and which settings are chosen
/// for each scene.
struct Recipe : NativeOptions {
    /// What chooseFromScene() chooses for each scene, instead of the recipe's own values.
    AutoChoices choices;
};

/// What a setting applies to.
enum class RecipePart {
    Views,     ///< The views and their depth, whatever they are used for.
    Placement, ///< How a picture is fitted, and the part of it that is shown.
    Native     ///< Natives only.
};

/// One setting of a recipe. Tools, saved settings and reports use the same names and words.
struct RecipeField {
    std::string name;       ///< As in `--name` and in JSON: "depth-curve".
    std::string valueName;  ///< "PERCENT"; words as "soft|hard"; empty for true or false.
    std::string help;       ///< A sentence for people; empty if only programs set it.
    RecipePart part{};      ///< What it applies to.
    bool isRare = false;    ///< Whether few people need it.
    double least = 0;       ///< Smallest number.
    double most = 0;        ///< Largest number.
    std::string expected{}; ///< Accepted values, for messages: "a number 0..100".
    /// The method that has this setting; nothing: all methods.
    std::optional<ViewMethod> method{};
    /// The value as text, which `read` accepts.
    std::function<std::string(const Recipe&)> text{};
    /// Sets the value. Returns false and changes nothing if the text is not a value of this field.
    std::function<bool(Recipe&, const std::string&)> read{};
};

/// All fields, in the order in which people set them.
/// @return the table
[[nodiscard]] ALTIRO3D_EXPORT const std::vector<RecipeField>& recipeFields();

/// The field of a name.
/// @param name as RecipeField::name
/// @return the field
/// @throws Error InvalidArgument (no field has this name)
[[nodiscard]] ALTIRO3D_EXPORT const RecipeField& recipeField(std::string_view name);

/// The settings as a JSON object with a member for each field: numbers, true or false, words such
/// as "layered", and "0.5,0.5" for the centre. A number or a fit that is chosen for each scene is
/// "auto". Settings without a field are not written: RealOptions::inpainting and inpaintingRadius,
/// LayeredOptions::tearPixels and edgeDilationPixels, stated flaws, AutoChoices::isVideo.
/// parseRecipe() refuses a strength above 100 %.
/// @param recipe the settings
/// @return the object, on one line
[[nodiscard]] ALTIRO3D_EXPORT std::string recipeText(const Recipe& recipe);

/// Reads what recipeText() has written. Missing members keep their defaults.
/// @param json a JSON object
/// @param source where it comes from, for errors
/// @return the settings
/// @throws Error BadFormat (invalid JSON, an unknown member, a wrong value); it names the source
///         and the member
[[nodiscard]] ALTIRO3D_EXPORT Recipe parseRecipe(const std::string& json,
                                                 const std::string& source);

/// Whether two recipes make the same pictures.
/// @param a one @param b the other @return true if all settings are equal
[[nodiscard]] ALTIRO3D_EXPORT bool operator==(const Recipe& a, const Recipe& b);
/// Whether two recipes differ. @param a one @param b the other @return true if a setting differs
[[nodiscard]] inline bool operator!=(const Recipe& a, const Recipe& b) {
    return !(a == b);
}

} // namespace altiro3D
