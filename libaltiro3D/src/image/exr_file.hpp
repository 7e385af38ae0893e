#pragma once

#include "altiro3D/image_io.hpp"
#include "image/opencv_codecs.hpp"

#include <opencv2/core/mat.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace altiro3D {

/// Channels of an EXR file that belong together.
struct ExrChoice {
    std::vector<ExrChannel> channels; ///< B, G, R and perhaps A of one layer, or one; or none.
    std::vector<std::string> others;  ///< Channels that might be meant as well.
};

/// What to read as a picture: colours without a layer, of "Combined" or the first layer, or grey.
ExrChoice chooseExrColours(const std::vector<ExrChannel>& channels);
/// Distances by their name: "Z", "Depth.V", "ViewLayer.Depth.Z", "depth"; none without such a name.
ExrChoice chooseExrDistance(const std::vector<ExrChannel>& channels);

/// The channels of an EXR file, without deep and subsampled ones. Empty if this build has no
/// OpenEXR: OpenCV then reads R, G, B and Y.
/// @throws PictureFailure
std::vector<ExrChannel> exrChannels(std::string_view bytes);

/// Reads channels of one part, in the display window; 0 outside the data window.
/// @return [rows x cols, CV_32FC(channels)]
/// @throws PictureFailure; std::bad_alloc
cv::Mat readExr(std::string_view bytes, const std::vector<ExrChannel>& channels);

/// Adds a remark that other channels might be meant as well. @param what "depth"
void addExrNotes(const ExrChoice& choice, const char* what, Notes* notes);

/// Decodes an EXR file.
/// @param asDepth a distance is read if there is one
/// @param notes if given, receives remarks on what was chosen
/// @return as readExr(); empty if OpenCV shall decode the file
/// @throws PictureFailure (also without a channel that can be meant); std::bad_alloc
cv::Mat decodeExr(std::string_view bytes, bool asDepth, Notes* notes);

/// The channel of an EXR file that holds distances.
/// @return its name; empty if there is none, and for other files
std::string exrDistanceOf(const PhotoFile& file);

} // namespace altiro3D
