// Pictures whose names say that they hold two halves: readNamedHalves() of depth_source.hpp.

#include "altiro3D/depth_source.hpp"
#include "altiro3D/image_io.hpp"

#include <algorithm>
#include <opencv2/core.hpp>

namespace altiro3D {

namespace {

namespace fs = std::filesystem;

void addPlain(Notes* notes, const SceneName& name, const std::string& why) {
    if (notes == nullptr) return;
    const bool isLightroom = name.tag == "LR" || name.tag == "lr";
    notes->push_back({NoteCode::AsItIs, "its name (" + name.tag + ") " + why +
                                            ": it is read as an ordinary photo" +
                                            (isLightroom ? " (LR may mean Lightroom)" : "")});
}

// A name is weak evidence, so it needs more than a match. Disparities of unrelated halves spread
// over 58 % of the width or more, those of real pairs over 3 to 10 % (docs/depth.md).
bool areEyes(const StereoMatch& match) {
    constexpr double kMaxRange = 0.4;
    return match.isReliable && match.nearest - match.farthest <= kMaxRange;
}

std::optional<PhotoDepth> readEyes(const SceneName& name, const cv::Mat& picture, Notes* notes) {
    const StereoPair pair = splitStereoPair(picture, name.layout, name.halves);
    PhotoDepth halves;
    const StereoMatch match = matchStereo(pair.left, pair.right, halves.rawDepth, &halves.hidden);
    if (!areEyes(match)) {
        addPlain(notes, name,
                 "may mean that it holds both eyes, but its halves do not resemble each other");
        return std::nullopt;
    }
    const Notes remarks = match.remarks(pair.origin);
    if (notes != nullptr) notes->insert(notes->end(), remarks.begin(), remarks.end());
    halves.photo = pair.left;
    halves.origin = DepthOrigin::Matched;
    halves.text = "stereo pair (" + pair.origin + ", by its name, " + name.tag +
                  "), depth by matching; " + match.text();
    return halves;
}

std::optional<PhotoDepth> readRgbd(const PhotoFile& file, const SceneName& name,
                                   const cv::Mat& picture, Notes* notes) {
    constexpr const char* kSides[] = {"right", "left", "upper", "lower"};
    const std::optional<DepthSide> side = findDepthHalf(picture, name.isStacked);
    if (!side) {
        addPlain(notes, name, "says that it holds depth, but no half of it is clearly depth");
        return std::nullopt;
    }
    PhotoDepth halves;
    halves.origin = DepthOrigin::Given;
    splitRgbd(readRgbdImage(file, *side), {*side, name.halves}, halves.photo, halves.rawDepth,
              notes);
    halves.text = std::string("depth half of the picture (") + kSides[static_cast<int>(*side)] +
                  ", by its name, " + name.tag + ")";
    return halves;
}

} // namespace

void refuseVrName(const fs::path& file) {
    const std::optional<SceneName> name = parseSceneName(file);
    if (!name || name->contents != SceneName::Contents::Vr) return;
    throw Error(ErrorCode::Unsupported, file.string(),
                "is made for headsets (VR) by its name (" + name->tag +
                    "), which is not read, expected a flat picture; if it is one, rename it");
}

std::optional<PhotoDepth> readNamedHalves(const PhotoFile& file, const cv::Mat& picture,
                                          Notes* notes) {
    const std::optional<SceneName> name = parseSceneName(file.path());
    if (!name || std::min(picture.cols, picture.rows) < 2) return std::nullopt;
    refuseVrName(file.path());
    try {
        return name->contents == SceneName::Contents::Eyes ? readEyes(*name, picture, notes)
                                                           : readRgbd(file, *name, picture, notes);
    } catch (const Error& error) {
        if (std::string(error.what()).find(file.path().string()) == 0) throw;
        throw Error(error.code(), file.path().string(), error.what());
    }
}

} // namespace altiro3D
