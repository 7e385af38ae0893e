#include "altiro3D/recipe.hpp"

#include "altiro3D/error.hpp"

#include <gtest/gtest.h>
#include <string>
#include <vector>

namespace altiro3D {
namespace {

// A recipe in which no field has its default value.
Recipe otherRecipe() {
    Recipe recipe;
    recipe.views.method = ViewMethod::Fast;
    recipe.views.strengthPercent = 7.3;
    recipe.views.focus = 1.0 / 3; // needs all digits
    recipe.views.refinement = 16;
    recipe.views.layered.fill = LayeredFill::Continue;
    recipe.views.layered.softBorders = false;
    recipe.views.real.backgroundOnly = true;
    recipe.fit = FitMode::Stretch;
    recipe.framing = {{0.25, 1}, 1000};
    recipe.refine.flaws = DepthFlaws();
    recipe.depthCurve = 0.5;
    recipe.detail = Detail::Lens;
    recipe.lensFilter = true;
    recipe.positions = ViewPositions::Continuous;
    recipe.sampling = {ViewFilter::Linear, TileSampling::Linear};
    recipe.choices.limit = true;
    return recipe;
}

std::string failure(const std::string& json) {
    try {
        (void)parseRecipe(json, "photo.json");
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadFormat);
        return error.what();
    }
    return "no error";
}

TEST(Recipe, IsSavedInWordsAndNumbersThatPeopleRead) {
    EXPECT_EQ(recipeText(Recipe()),
              R"({"method":"layered","strength":10,"limit-strength":false,"focus":0.5,)"
              R"("depth-curve":1,"exact-depth":false,"fill":"background","borders":"soft",)"
              R"("refine":0,"inpaint-from":"around","fit":"cover","center":"0.5,0.5","zoom":1,)"
              R"("detail":"view","lens-filter":false,"positions":"discrete",)"
              R"("view-filter":"nearest","sampling":"nearest"})");
    EXPECT_EQ(recipeText(otherRecipe()),
              R"({"method":"fast","strength":7.3,"limit-strength":true,)"
              R"("focus":0.3333333333333333,"depth-curve":0.5,"exact-depth":true,)"
              R"("fill":"continue","borders":"hard","refine":16,"inpaint-from":"behind",)"
              R"("fit":"stretch","center":"0.25,1","zoom":1000,"detail":"lens",)"
              R"("lens-filter":true,"positions":"continuous","view-filter":"linear",)"
              R"("sampling":"linear"})");
    Recipe automatic;
    automatic.choices = {true, true, true};
    EXPECT_EQ(recipeText(automatic).substr(0, 69),
              R"({"method":"layered","strength":"auto","limit-strength":false,"focus":)");
    EXPECT_EQ(recipeField("fit").text(automatic), "auto");
}

TEST(Recipe, ComesBackAsItWasSaved) {
    Recipe automatic = otherRecipe();
    automatic.fit = FitMode::Cover;
    automatic.views.strengthPercent = ViewOptions().strengthPercent;
    automatic.views.focus = ViewOptions().focus;
    automatic.choices = {true, true, true};
    for (const Recipe& recipe : {Recipe(), otherRecipe(), automatic}) {
        const Recipe read = parseRecipe(recipeText(recipe), "photo.json");
        EXPECT_EQ(recipeText(read), recipeText(recipe));
        EXPECT_TRUE(read == recipe);
    }
    EXPECT_TRUE(parseRecipe("{}", "photo.json") == Recipe());
}

TEST(Recipe, DiffersByEachField) {
    const Recipe other = otherRecipe();
    for (const RecipeField& field : recipeFields()) {
        Recipe recipe;
        EXPECT_TRUE(field.read(recipe, field.text(other))) << field.name;
        EXPECT_TRUE(recipe != Recipe()) << field.name;
        EXPECT_NE(field.text(recipe), field.text(Recipe())) << field.name;
        EXPECT_TRUE(field.read(recipe, field.text(Recipe()))) << field.name;
        EXPECT_TRUE(recipe == Recipe()) << field.name;
    }
}

TEST(Recipe, RefusesWhatIsNoValueAndChangesNothing) {
    const std::vector<std::string> nonsense = {"",      " ",     "none", "AUTO", "nan",   "inf",
                                               "-1",    "10001", "0x1",  "+1",   "1 ",    " 1",
                                               "1e400", "1,",    ",1",   "1,2",  "1,1,1", "true "};
    for (const RecipeField& field : recipeFields()) {
        Recipe recipe = otherRecipe();
        for (const std::string& text : nonsense)
            EXPECT_FALSE(field.read(recipe, text)) << field.name << " " << text;
        EXPECT_TRUE(recipe == otherRecipe()) << field.name;
        EXPECT_FALSE(field.expected.empty()) << field.name;
    }
}

TEST(Recipe, NumbersEndAtTheirRanges) {
    struct Range {
        const char* field;
        double least, most;
    };
    for (const Range& range : {Range{"strength", 0, 100},
                               {"focus", 0, 1},
                               {"depth-curve", 0.5, 2},
                               {"refine", 0, 16},
                               {"zoom", 1, 1000}}) {
        const RecipeField& field = recipeField(range.field);
        Recipe recipe;
        EXPECT_EQ(field.least, range.least) << range.field;
        EXPECT_EQ(field.most, range.most) << range.field;
        for (const double end : {range.least, range.most})
            EXPECT_TRUE(field.read(recipe, std::to_string(end))) << range.field;
        EXPECT_FALSE(field.read(recipe, std::to_string(range.least - 0.001))) << range.field;
        EXPECT_FALSE(field.read(recipe, std::to_string(range.most + 0.001))) << range.field;
    }
    Recipe recipe;
    EXPECT_FALSE(recipeField("refine").read(recipe, "1.5"));
}

TEST(Recipe, ErrorsNameTheMemberAndWhatWasExpected) {
    EXPECT_EQ(failure(R"({"focus": 2})"), "photo.json: focus: is 2, expected a number 0..1");
    EXPECT_EQ(failure(R"({"refine": 1.5})"),
              "photo.json: refine: is 1.5, expected a whole number 0..16");
    EXPECT_EQ(failure(R"({"method": 2})"),
              "photo.json: method: is 2, expected layered, fast or real");
    EXPECT_EQ(failure(R"({"fit": "fill"})"),
              "photo.json: fit: is \"fill\", expected cover, contain, stretch or auto");
    EXPECT_EQ(failure(R"({"center": [0.5, 0.5]})"),
              "photo.json: center: is a list, expected two numbers 0..1 with a comma, such as "
              "0.3,0.5");
    EXPECT_EQ(failure(R"({"exact-depth": 1})"),
              "photo.json: exact-depth: is 1, expected true or false");
    EXPECT_EQ(failure(R"({"depth": 1})"), "photo.json: depth: is not a setting of a picture");
    EXPECT_NE(failure("[]"), "no error");
    EXPECT_NE(failure("{"), "no error");
    EXPECT_THROW((void)recipeField("depth"), Error);
}

} // namespace
} // namespace altiro3D
