#include "slide/slide_strangers.hpp"

#include "base/checks.hpp"
#include "image/pixel_values.hpp"
#include "slide/slide_checks.hpp"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

// Removes pictures that do not continue the others; keeps the longest row of pictures in which each
// shows what the one before shows. @return what was removed
std::vector<SlidePicture> removeStrangers(std::vector<SlidePicture>& pictures,
                                          const PictureSteps& steps) {
    constexpr std::size_t kRuns = 3;   // runs that a picture may continue
    constexpr int kFewest = 10;        // corners of stepsOf()
    constexpr double kSharpness = 0.1; // sharpness of one picture against the other
    const auto areNeighbours = [&](std::size_t a, std::size_t b) {
        if (std::min(pictures[a].sharpness, pictures[b].sharpness) <
            kSharpness * std::max(pictures[a].sharpness, pictures[b].sharpness))
            return false;
        const int count = b == a + 1
                              ? steps.counts[b]
                              : stepsWith({pictures[a], pictures[b]}, steps.window).counts.back();
        return count >= kFewest;
    };
    // pictures that continue each other; those that were continued last come first
    std::vector<std::vector<std::size_t>> runs;
    for (std::size_t i = 0; i < pictures.size(); ++i) {
        const auto end = runs.begin() + static_cast<std::ptrdiff_t>(std::min(kRuns, runs.size()));
        auto run = std::find_if(runs.begin(), end,
                                [&](const auto& one) { return areNeighbours(one.back(), i); });
        if (run == end) run = runs.insert(runs.begin(), std::vector<std::size_t>());
        run->push_back(i);
        std::rotate(runs.begin(), run, run + 1);
    }
    const auto isShorter = [](const auto& a, const auto& b) { return a.size() < b.size(); };
    const std::vector<std::size_t>& longest =
        *std::max_element(runs.begin(), runs.end(), isShorter);
    std::vector<SlidePicture> kept;
    std::vector<SlidePicture> strangers;
    for (std::size_t i = 0; i < pictures.size(); ++i)
        (std::binary_search(longest.begin(), longest.end(), i) ? kept : strangers)
            .push_back(pictures[i]);
    pictures = std::move(kept);
    return strangers;
}

std::string nameOf(const SlidePicture& picture, const SlideNames& names) {
    const auto number = static_cast<std::size_t>(picture.number);
    return number < names.pictures.size() ? names.pictures[number]
                                          : "picture " + std::to_string(number + 1);
}

} // namespace

PictureSteps leaveOutStrangers(std::vector<SlidePicture>& pictures, const SlideNames& names,
                               Notes& notes) {
    PictureSteps found = stepsOf(pictures);
    const std::vector<double> counts(std::next(found.counts.begin()), found.counts.end());
    requireCorners(static_cast<int>(percentileOf(counts, 0.5)), names.clip);
    const std::size_t all = pictures.size();
    const std::size_t most = std::max<std::size_t>(2, all / 10);
    std::vector<SlidePicture> kept = pictures;
    const std::vector<SlidePicture> strangers = removeStrangers(kept, found);
    // if none are left, following corners reports what is missing
    if (strangers.empty() || kept.size() < 2) return found;
    if (strangers.size() > most) {
        constexpr std::size_t kNamed = 8;
        std::string first;
        for (std::size_t i = 0; i < std::min(kNamed, strangers.size()); ++i)
            first += (i > 0 ? ", " : "") + nameOf(strangers[i], names);
        throw Error(ErrorCode::BadFormat, names.clip,
                    std::to_string(strangers.size()) + " of " + std::to_string(all) +
                        " pictures do not show the scene of the others (" + first +
                        (strangers.size() > kNamed ? ", ..." : "") + "), expected " +
                        std::to_string(most) + " at most");
    }
    std::vector<double> sharp;
    for (const SlidePicture& one : kept)
        sharp.push_back(one.sharpness);
    for (const SlidePicture& one : strangers) {
        const double mean = cv::mean(one.grey)[0];
        const bool isBlurred = one.sharpness < 0.1 * percentileOf(sharp, 0.5);
        addNote(&notes, NoteCode::LeftOut,
                nameOf(one, names) + " is left out: it " +
                    (mean < 16    ? "is black"
                     : mean > 240 ? "is white"
                     : isBlurred  ? "is blurred"
                                  : "does not show what its neighbours show"));
    }
    pictures = std::move(kept);
    return stepsOf(pictures);
}

} // namespace altiro3D
