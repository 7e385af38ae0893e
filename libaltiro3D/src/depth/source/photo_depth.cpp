#include "depth/source/photo_depth.hpp"

#include "altiro3D/depth_map.hpp"
#include "altiro3D/image_io.hpp"
#include "base/checks.hpp"
#include "image/picture_halves.hpp"

namespace altiro3D {

PhotoDepth matchedDepth(const StereoPair& pair, Notes& notes) {
    PhotoDepth found;
    const StereoMatch match = matchStereo(pair.left, pair.right, found.rawDepth, &found.hidden);
    notes = match.remarks(pair.origin);
    found.photo = pair.left;
    if (match.isReliable) {
        found.origin = DepthOrigin::Matched;
        found.text = "stereo pair (" + pair.origin + "), depth by matching; " + match.text();
    } else {
        found.rawDepth.release();
    }
    return found;
}

std::optional<PhotoDepth> matchedDepth(const SceneName& name, const cv::Mat& picture,
                                       const std::filesystem::path& file, std::string_view bytes,
                                       Notes* notes) {
    Notes remarks;
    const StereoPair pair =
        splitNamedHalves(picture, name.layout, name.halves, file, bytes, &remarks);
    PhotoDepth halves;
    const StereoMatch match = matchStereo(pair.left, pair.right, halves.rawDepth, &halves.hidden);
    if (!match.areEyes()) { // a name is weak evidence, so it needs more than a match
        addReadAsPhoto(
            notes, name,
            "may mean that it holds both eyes, but its halves do not resemble each other");
        return std::nullopt;
    }
    addNotes(notes, remarks);
    const Notes ofMatch = match.remarks(pair.origin);
    addNotes(notes, ofMatch);
    halves.photo = pair.left;
    halves.origin = DepthOrigin::Matched;
    halves.text = "stereo pair (" + pair.origin + ", by its name, " + name.tag +
                  "), depth by matching; " + match.text();
    return halves;
}

void addReadAsPhoto(Notes* notes, const SceneName& name, const std::string& why) {
    const bool isLightroom = name.tag == "LR" || name.tag == "lr";
    addNote(notes, NoteCode::AsItIs,
            "its name (" + name.tag + ") " + why + ": it is read as an ordinary photo" +
                (isLightroom ? " (LR may mean Lightroom)" : ""));
}

void refuseVrName(const std::filesystem::path& file) {
    const std::optional<SceneName> name = parseSceneName(file);
    if (!name || name->contents != SceneName::Contents::Vr) return;
    throw Error(ErrorCode::Unsupported, file.string(),
                "is made for headsets (VR) by its name (" + name->tag +
                    "), which is not read, expected a flat picture; if it is one, rename it");
}

void makeScene(const PhotoDepth& found, double flatDepth, Scene& scene) try {
    DepthNormalization normalization;
    normalization.kind = found.kind;
    normalization.flatDepth = flatDepth;
    scene = Scene();
    scene.photo = found.photo;
    scene.hidden = found.hidden;
    if (found.origin == DepthOrigin::Matched) scene.edges = DepthEdges::Matched;
    normalizeDepth(found.rawDepth, scene.depth, normalization);
    if (!scene.hidden.photo.empty()) scaleHiddenDepth(found.rawDepth, scene.depth, scene.hidden);
} catch (const cv::Exception& exception) {
    leaveAsOurs(exception);
}

} // namespace altiro3D
