#pragma once

#include "altiro3D/camera_slide.hpp"
#include "altiro3D/photo_fit.hpp"
#include "altiro3D/quilt.hpp"
#include "cli/run_tool.hpp"

#include <cstddef>
#include <filesystem>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

namespace altiro3D::tools {

/// Pictures of a folder below this number are not taken for views: bursts have a few pictures.
constexpr std::size_t kFewestViews = 8;

/// As listImages(), but if the numbers of a camera begin again in the folder, IMG_0001 follows
/// IMG_9999.
/// @param notes is told so @throws Error NotFound (there are none)
std::vector<std::filesystem::path> listViews(const std::filesystem::path& directory, Notes* notes);

/// Why the pictures of a folder are not views of one scene from a row of cameras. They are if there
/// are enough, of one size, if one number in their names counts in equal steps, if
/// neighbours resemble each other, and if the camera moves in one direction, not up or down.
///
/// @param files all pictures of the folder, as listViews()
/// @param fewest number of views at least, 2 or more
/// @return empty if they are views; else "holds 3 pictures". Some pictures are read; if one cannot
///         be read, the reason says so.
std::string reasonAgainstViews(const std::vector<std::filesystem::path>& files,
                               std::size_t fewest = kFewestViews);

/// How unrelated pictures follow each other from view to view.
enum class FlipKind {
    Hard, ///< Each view shows one of them, each of them has as many views.
    Soft  ///< Views between two of them show both.
};

/// A quilt and the size of its views in their files.
struct ViewsQuilt {
    cv::Mat quilt;     ///< [layout size, CV_8UC3, BGR]
    cv::Size viewSize; ///< Px.
};

/// Reads sorted views into a quilt. If their number differs from the layout's, each tile takes the
/// view of the nearest position.
///
/// @param files from the leftmost camera to the rightmost, at least one
/// @param aspect width : height of the panel, to which `mode` fits each view
/// @param atFile called once with each file, before it is read; its exceptions end the work. A file
///        that no tile shows is not read.
/// @param flip the pictures are unrelated, of any size, and each has its part of the views
/// @throws Error as readPhoto(), Mismatch (views of different sizes), BadFormat (Natives)
ViewsQuilt quiltOfViews(const std::vector<std::filesystem::path>& files, const QuiltLayout& layout,
                        double aspect, FitMode mode, Messages& messages,
                        const std::function<void(const std::filesystem::path&)>& atFile,
                        std::optional<FlipKind> flip = std::nullopt);

/// The pictures of a camera that moves sideways: the frames of a video, or photos.
/// @param inputs a video, a folder of photos, or photos
/// @param files receives the files that are read @param notes as for slideVideo()
/// @throws Error NotFound
SlidePictureSource slideOf(const std::vector<std::filesystem::path>& inputs,
                           std::vector<std::filesystem::path>& files, Notes* notes);
/// Options of a slide whose views become a quilt.
/// @param aspect,mode as for quiltOfViews()
SlideOptions slideOptionsFor(const QuiltLayout& layout, double aspect, FitMode mode,
                             const SlideOptions& options = {});
/// The quilt of a slide's views.
/// @param atView if given, called with each view before it is fitted
cv::Mat quiltOfSlide(CameraSlide& slide, const QuiltLayout& layout, double aspect, FitMode mode,
                     const std::function<void(int, const cv::Mat&)>& atView = {});

} // namespace altiro3D::tools
