#pragma once

#include "viewer/model/knobs.hpp"

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D::viewer {

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
