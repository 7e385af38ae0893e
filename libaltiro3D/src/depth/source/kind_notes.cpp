#include "depth/source/kind_notes.hpp"

#include "base/checks.hpp"
#include "depth/map/depth_values.hpp"
#include "image/exr_file.hpp"

namespace altiro3D {

void addKindNotes(const PhotoFile& file, const cv::Mat& raw, DepthKind kind, Notes* notes) {
    const std::string channel = kind == DepthKind::NearWhite ? exrDistanceOf(file) : std::string();
    if (!channel.empty()) {
        addNote(notes, NoteCode::Doubtful,
                "its channel " + channel +
                    " holds distances by its name, but large numbers count "
                    "as near: for distances, expected --depth-kind metric");
    }
    const int unknown = kind == DepthKind::Metric ? unknownFarthest(raw) : 0;
    if (unknown > 0) {
        addNote(notes, NoteCode::Doubtful,
                "65535 counts as unknown, like 0, as no other distance is near it: " +
                    std::to_string(unknown) + " of " + std::to_string(raw.total()) + " px");
    }
}

} // namespace altiro3D
