#pragma once

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/recipe.hpp"
#include "cli/display_options.hpp"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D::viewer {

/// The picture's own depth, else depth from standardNetwork().
constexpr const char* kBestDepth = "best";
/// The picture's own depth.
constexpr const char* kGivenDepth = "given";

/// All settings that the user can change while viewing; each file has its own, see Settings. A
/// video has no choices unless the user asks for them, see ofVideo().
struct Knobs : Recipe {
    Knobs() { choices = {true, true, false, true}; }

    /// The framing was chosen by the photo, before strokes of a brush fixed it: the sway video
    /// shows the whole photo.
    bool isFramingChosen = false;
    std::string depth = kBestDepth; ///< One of the two names above, or a network's name.
    int columns = 0;                ///< Columns of the quilt; 0: the display's default.
    int rows = 0;                   ///< Rows of the quilt; 0: the display's default.
};

/// A new number for changes that are undone together.
int nextGesture();

/// Settings for a video that has none of its own: those of video2native.
inline Knobs ofVideo(Knobs knobs) {
    knobs.choices = {};
    return knobs;
}

bool operator==(const Knobs& a, const Knobs& b);
inline bool operator!=(const Knobs& a, const Knobs& b) {
    return !(a == b);
}

/// The quilt layout for a display: its default, with the columns and rows of the settings.
QuiltLayout layoutOf(const Knobs& knobs, const Display& display);

// The part of a photo that is shown, as the mouse changes it. Nothing of it throws for a photo of
// at least 1 x 1 px and a display.

/// The wheel enlarges no further.
constexpr double kMaxZoom = 100;

/// What a framing applies to.
struct FramedPhoto {
    cv::Size size;                ///< The photo's, px.
    double panelAspect = 1;       ///< Width : height of the panel, 0.01..100.
    FitMode fit = FitMode::Cover; ///< How the photo is fitted.
};

/// The framing that this photo allows: its zoom leaves at least kMinFramedPixels rows and
/// columns.
Framing allowed(const Framing& framing, const FramedPhoto& photo);

/// The framing after the picture was dragged; content follows the mouse, up to the photo's ends.
/// @param by in widths and heights of the picture on the panel
Framing moved(const Framing& framing, const FramedPhoto& photo, cv::Point2d by);

/// The framing after a zoom, 1..kMaxZoom; content at the mouse stays, up to the photo's ends.
/// @param at place of the mouse in the picture on the panel, 0..1 @param factor > 0
Framing zoomed(const Framing& framing, const FramedPhoto& photo, cv::Point2d at, double factor);

/// The settings of each photo, kept from run to run in one JSON file. A photo is known by its path,
/// size and time of change: other contents of the same name have no settings. One thread at a time.
class KnobStore {
  public:
    /// The most photos that the file keeps; the settings that were changed first are dropped.
    static constexpr std::size_t kMaxPhotos = 5000;
    /// The largest file that is read, bytes.
    static constexpr std::size_t kMaxBytes = 8u << 20;

    /// Reads the file. A missing file is empty; one that cannot be used counts as empty and gives a
    /// note.
    explicit KnobStore(std::filesystem::path file);

    /// $XDG_DATA_HOME/altiro3D/settings-of-photos.json, or in ~/.local/share if that is not set.
    static std::filesystem::path standardFile();

    /// Why the file is not used, one sentence; empty if it is.
    const std::string& note() const { return note_; }

    /// The settings of a photo; nothing if it has none of its own.
    std::optional<Knobs> find(const std::filesystem::path& photo) const;
    /// Sets them; save() keeps them.
    void set(const std::filesystem::path& photo, const Knobs& knobs);
    /// Writes what has changed; what another viewer has written since stays. Not possible without a
    /// place to write: then nothing is kept, and note() says so.
    void save();

  private:
    struct Entry {
        std::string key; ///< File and stamp.
        Knobs knobs;
    };
    static std::vector<Entry> read(const std::filesystem::path& file, std::string& note);

    std::filesystem::path file_;
    std::string note_;
    std::map<std::string, Knobs> knobs_;
    std::vector<std::string> changed_; // keys, the latest last
};

} // namespace altiro3D::viewer
