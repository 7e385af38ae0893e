#pragma once

#include "video/chunks/chunk_plan.hpp"
#include "video/conversion/video_sink.hpp"

#include <cstdint>
#include <filesystem>
#include <optional>

namespace altiro3D {

/// The states that chunks leave for others. A state that cannot be used is as if it were not there,
/// because depth can always be made from the start of the scene.
class ChunkStates {
  public:
    /// @param directory the folder of the plan @param processor see ChunkRecord
    ChunkStates(const std::filesystem::path& directory, const ChunkPlan& plan,
                std::uint64_t processor);

    /// Writes the state before a frame, unless it is there. @throws Error WriteFailed
    void keep(std::int64_t frame, const SavedState& state) const;
    /// Reads the state before a frame; nothing if there is none or it is damaged or of another plan
    /// or processor.
    std::optional<SavedState> take(std::int64_t frame) const;

  private:
    std::filesystem::path nameOf(std::int64_t frame) const;

    std::filesystem::path directory_;
    std::uint64_t id_;
    std::uint64_t processor_;
};

} // namespace altiro3D
