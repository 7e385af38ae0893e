#pragma once

#include "media/video_input.hpp"

#include <string>
#include <string_view>

/// What a video states of both eyes and of its projection, where FFmpeg does not read it.
namespace altiro3D {

/// How surely a stream holds depth, by its title and by its px: one grey value of 16 bits.
int likenessToDepth(const AVStream& stream);

/// Finds out how a video holds both eyes and whether they are to be joined. Sets `stream` to the
/// left eye's video where it is known, all that VideoInput states of eyes but for its facts, and
/// remarks.
/// @param head VideoInput::head
/// @throws Error Unsupported (two videos are wanted, but it does not have them)
void findOtherEye(VideoInput& input, const VideoReaderOptions& options, const std::string& head);

/// Fills in what the facts say of eyes, and corrects their size and shape. @param head as before
void describeEyes(VideoInput& input, const std::string& head);

/// Refuses videos of a sphere or of half of one, because their pictures are bent.
/// @throws Error Unsupported, with the command that makes a flat video
void refuseSpherical(const VideoInput& input, std::string_view head);

} // namespace altiro3D
