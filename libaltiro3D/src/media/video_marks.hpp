#pragma once

#include "media/video_input.hpp"

#include <string>
#include <string_view>

/// What a video states about both eyes and about its projection, where FFmpeg does not read it.
namespace altiro3D {

/// How likely a stream holds depth, 0..3: by its title, and whether its px are grey of 16 bits.
int likenessToDepth(const AVStream& stream);

/// Finds out how a video holds both eyes and whether to join them. Sets `stream` to the left eye's
/// video if known, the other members of VideoInput about eyes except its facts, and remarks.
/// @param head VideoInput::head
/// @throws Error Unsupported (two videos are wanted, but it does not have them)
void findOtherEye(VideoInput& input, const VideoReaderOptions& options, const std::string& head);

/// Fills in the facts about eyes, and corrects their size and shape. @param head VideoInput::head
void describeEyes(VideoInput& input, const std::string& head);

/// Refuses videos of a sphere or of half of one, because their pictures are bent.
/// @throws Error Unsupported, with the command that makes a flat video
void refuseSpherical(const VideoInput& input, std::string_view head);

} // namespace altiro3D
