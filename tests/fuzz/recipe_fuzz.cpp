// The settings of a picture, as programs save them.

#include "altiro3D/recipe.hpp"
#include "fuzz.hpp"

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string text(fuzz::textOf(data, size));
    fuzz::reads([&] {
        const Recipe recipe = parseRecipe(text, "recipe.json");
        const std::string saved = recipeText(recipe);
        if (recipeText(parseRecipe(saved, "saved")) != saved) std::abort();
    });
    return 0;
}
