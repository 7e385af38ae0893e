#pragma once

#include "altiro3D/image_io.hpp"

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace altiro3D {

/// The bytes of a further picture inside a JPEG.
struct CodedPart {
    std::string_view coded; ///< A JPEG or PNG inside the file; empty: `decoded`.
    int orientation = 1;    ///< 1..8, EXIF; that of the photo, if the part states none.
    std::string decoded;    ///< A JPEG or PNG that was base64; empty: there is none.

    /// The coded picture, wherever it is.
    std::string_view picture() const { return coded.empty() ? std::string_view(decoded) : coded; }
};

/// A depth picture and what it means.
struct DepthPart : CodedPart {
    EmbeddedDepthForm form = EmbeddedDepthForm::DynamicDepth;
    bool isNearBright = false; ///< Large = near.
    bool isDistance = false;   ///< The numbers grow with the distance, from nearest to farthest.
    double nearest = 0;        ///< With isDistance: distance of 0; 0 = not stated.
    double farthest = 0;       ///< With isDistance: distance of the largest number; 0 = not stated.
};

/// The right eye's picture; decoded if it is of Cardboard Camera.
using SecondEye = CodedPart;

/// Finds depth in a JPEG file: Dynamic Depth, GDepth, Apple's, in this order.
/// Any bytes give a result. The result points into the bytes.
std::optional<DepthPart> findDepthPart(std::string_view jpeg);

/// Finds the right eye's picture in a JPEG file of a 3D camera (MPO): the picture after the first
/// one, if the index of pictures gives its type as "multi-frame image, disparity". Or in one of
/// Cardboard Camera: `GImage` of a panorama (`GPano`).
SecondEye findSecondEye(std::string_view jpeg);

/// Finds the sharp original in a JPEG file.
/// @param decoded holds the result if it was base64
/// @return a JPEG or PNG in the file or in `decoded`; empty if there is none
std::string_view findUnblurred(std::string_view jpeg, std::string& decoded);

/// Reads the sharp original of a photo that was blurred by its camera (portrait modes): `GImage` of
/// lens blur, item "Original" of Dynamic Depth. It may be smaller than the photo.
/// @param photo as for readEmbeddedDepth()
/// @param notes if given, receives a remark if there is an original that cannot be used
/// @return [rows x cols, CV_8UC3, BGR], upright; empty if the file has none of the photo's shape
/// @throws Error as readEmbeddedDepth()
cv::Mat readUnblurredPhoto(const PhotoFile& photo, Notes* notes = nullptr);

} // namespace altiro3D
