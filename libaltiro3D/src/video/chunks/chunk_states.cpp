#include "video/chunks/chunk_states.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/file_io.hpp"
#include "base/state_bytes.hpp"

#include <string>
#include <string_view>
#include <system_error>

namespace altiro3D {

namespace fs = std::filesystem;

namespace {

constexpr std::uintmax_t kMaxStateBytes = std::uintmax_t{1} << 30;

} // namespace

ChunkStates::ChunkStates(const fs::path& directory, const ChunkPlan& plan, std::uint64_t processor)
    : directory_(directory / kStates), id_(plan.id), processor_(processor) {}

void ChunkStates::keep(std::int64_t frame, const SavedState& state) const {
    if (take(frame)) return;
    std::string bytes;
    append(bytes, id_);
    append(bytes, processor_);
    append(bytes, static_cast<std::uint64_t>(frame));
    bytes += state.bytes;
    append(bytes, checksum(bytes));
    writeFile(nameOf(frame), bytes);
}

std::optional<SavedState> ChunkStates::take(std::int64_t frame) const {
    std::error_code error;
    if (!fs::exists(nameOf(frame), error)) return std::nullopt;
    try {
        const std::string bytes = readFile(nameOf(frame), kMaxStateBytes);
        constexpr std::size_t kNumber = sizeof(std::uint64_t);
        if (bytes.size() < 4 * kNumber) return std::nullopt;
        std::string_view rest(bytes);
        std::string_view end = rest.substr(rest.size() - kNumber);
        rest.remove_suffix(kNumber);
        const std::uint64_t sum = checksum(rest);
        for (const std::uint64_t expected : {id_, processor_, static_cast<std::uint64_t>(frame)}) {
            std::uint64_t value = 0;
            if (!altiro3D::take(rest, value) || value != expected) return std::nullopt;
        }
        std::uint64_t written = 0;
        if (!altiro3D::take(end, written) || written != sum) return std::nullopt;
        return SavedState{std::string(rest)};
    } catch (const Error&) {
        return std::nullopt;
    }
}

fs::path ChunkStates::nameOf(std::int64_t frame) const {
    return directory_ / (std::to_string(frame) + ".state");
}

} // namespace altiro3D
