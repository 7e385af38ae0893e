#pragma once

#include "altiro3D/export.hpp"

#include <cstddef>
#include <filesystem>
#include <memory>

namespace altiro3D {

/// Options to read the sound of a file.
struct AudioReaderOptions {
    /// Index of the sound stream in the file (VideoStreamFacts::index); -1 = the default one.
    int stream = -1;
    int sampleRate = 48000; ///< Samples per second to deliver, 4000..384000.
    double from = 0;        ///< Start, s from the start of the file, 0 or more, less than 1e9.
};

/// Reads one sound track of a file through FFmpeg's libraries, as stereo samples in 32-bit floating
/// point (-1..1). Other channel layouts are mixed to stereo.
///
/// The first sample delivered belongs to the time `from` of the file, on the same clock as the
/// frames of VideoReader. Where the track has no sound (before its start, in a gap), silence is
/// delivered; a damaged packet is skipped and replaced by silence. After a seek the time is as
/// exact as the container's times: to the sample in .wav, .flac, .mov and .mp4, to 1 ms in .mkv. A
/// mono track is delivered in both channels at 71 % of its amplitude, which is as loud.
///
/// The class turns FFmpeg's messages off as VideoReader does. One thread at a time per object.
class ALTIRO3D_EXPORT AudioReader {
  public:
    /// Opens a sound track.
    ///
    /// @param path a file that FFmpeg can read
    /// @param options track, rate and start
    /// @throws Error NotFound; ReadFailed; BadFormat (no sound, or `options.stream` is not a sound
    ///         stream); Unsupported (a codec without a decoder, a rate of the file outside
    ///         1000..768000 samples per second); InvalidArgument (options); OutOfMemory
    explicit AudioReader(const std::filesystem::path& path, const AudioReaderOptions& options = {});
    ~AudioReader();
    AudioReader(AudioReader&&) noexcept;            ///< Moves.
    AudioReader& operator=(AudioReader&&) noexcept; ///< Moves. @return *this

    /// Reads the next samples.
    ///
    /// @param samples receives left and right in turn, 2 * `count` numbers
    /// @param count number of samples per channel
    /// @return number of samples per channel that were read; less than `count` only at the end
    /// @throws Error OutOfMemory; Unsupported (the rate changes to one outside the limits)
    [[nodiscard]] std::size_t read(float* samples, std::size_t count);

    /// Goes to another time; the next sample read belongs to it.
    ///
    /// @param seconds s from the start of the file, 0 or more, less than 1e9; after the end:
    ///        nothing is left to read
    /// @throws Error InvalidArgument; ReadFailed (the file does not allow to seek)
    void seek(double seconds);

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace altiro3D
