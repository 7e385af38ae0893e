// What --budget keeps of its measurements.

#include "altiro3D/error.hpp"
#include "cli/budget.hpp"
#include "cli/run_tool.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace altiro3D::test {

using namespace tools;

namespace {

// How often the first of two sources of depth was tried in two runs.
int triesOfASourceThatFails(ErrorCode code, const std::string& work) {
    int tries = 0;
    for (int i = 0; i < 2; ++i) {
        CommandLine commandLine("tool", "Tests.");
        Budget::add(commandLine);
        commandLine.parse({"tool", "--budget=60000"});
        Budget budget(commandLine);
        Messages messages("tool", false);
        messages.leaveStandardOutput();
        const std::vector<BudgetDepth> depths = {
            {"first", [&] { throw Error(code, "first", "fails " + std::to_string(++tries)); },
             [] {}},
            {"second", [] {}, [] {}}};
        const BudgetSetting chosen = budget.choose(
            {}, work, depths, [](const ViewOptions&) {}, messages);
        EXPECT_EQ(chosen.depth, 1U);
        const auto report = nlohmann::json::parse(budget.report().dump());
        EXPECT_TRUE(report.at("measuredDepths").at(0).at("milliseconds").is_null()) << report;
        EXPECT_TRUE(report.at("measuredDepths").at(1).at("milliseconds").is_number()) << report;
    }
    return tries;
}

} // namespace

TEST(Budget, TriesASourceAgainThatLackedMemory) {
    EXPECT_EQ(triesOfASourceThatFails(ErrorCode::OutOfMemory, "memory"), 2);
}

TEST(Budget, RemembersASourceThatCannotRun) {
    EXPECT_EQ(triesOfASourceThatFails(ErrorCode::NetworkFailed, "network"), 1);
}

} // namespace altiro3D::test
