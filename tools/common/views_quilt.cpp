#include "common/views_quilt.hpp"

#include "altiro3D/error.hpp"
#include "common/picture_options.hpp"

#include <cmath>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

// The picture nearest to a view's camera position among `pictures` evenly spaced ones.
std::size_t pictureOfView(int view, int views, std::size_t pictures) {
    const double place = (viewPosition(view, views) + 1) / 2 * static_cast<double>(pictures - 1);
    return static_cast<std::size_t>(std::lround(place));
}

} // namespace

ViewsQuilt quiltOfViews(const std::vector<fs::path>& files, const QuiltLayout& layout,
                        double aspect, FitMode mode, Messages& messages,
                        const std::function<void(const fs::path&)>& atFile) {
    if (files.size() != static_cast<std::size_t>(layout.viewCount)) {
        messages.warn("there are " + counted(files.size(), "picture") + " for " +
                      counted(layout.viewCount, "view") +
                      ": each view takes the picture nearest to it");
    }
    ViewsQuilt result;
    result.quilt = cv::Mat(layout.size(), CV_8UC3, cv::Scalar::all(0));
    for (const fs::path& file : files)
        refuseNative(file, "views of one scene, a file for each");
    cv::Size& viewSize = result.viewSize;
    for (std::size_t picture = 0; picture < files.size(); ++picture) {
        cv::Mat view; // read for its first tile; not read without any
        cv::Mat fitted;
        atFile(files[picture]);
        for (int i = 0; i < layout.viewCount; ++i) {
            if (pictureOfView(i, layout.viewCount, files.size()) != picture) continue;
            if (view.empty()) {
                view = readPhotoFile(files[picture], messages);
                if (viewSize.area() == 0) viewSize = view.size();
                if (view.size() != viewSize) {
                    throw Error(ErrorCode::Mismatch, files[picture].string(),
                                "has " + sizeText(view.size()) + ", expected " +
                                    sizeText(viewSize) + " like the views before it");
                }
                applyFit(view, fitPhoto(viewSize, aspect, layout.tileSize, mode), fitted);
            }
            fitted.copyTo(result.quilt(layout.tile(i)));
        }
    }
    return result;
}

} // namespace altiro3D::tools
