#pragma once

#include "altiro3D/photo_fit.hpp"
#include "viewer/document.hpp"
#include "viewer/knobs.hpp"

#include <functional>
#include <memory>

namespace altiro3D::viewer {

/// Takes how much is done, 0..1, and says whether to go on.
using Progress = std::function<bool(double)>;

/// A document with all that its pictures are made of and by.
struct Setup {
    std::shared_ptr<const Document> document;
    cv::Mat depth;     ///< Of a photo: [any size, CV_32FC1, 0..1], shows all of it.
    bool flat = false; ///< The depth has no range: it lies at the focus, see layFlatDepth().
    Knobs knobs;
    std::shared_ptr<const Display> display;
};

/// Brings depth without a range to the focus, as the tools do: nothing moves from view to view.
void layFlatDepth(Setup& setup);

/// The layout of the quilt: that of a quilt itself, else what the knobs mean.
QuiltLayout quiltLayout(const Setup& setup);

/// Photo and depth of a setup, brought to the panel's shape; of quilts and Natives nothing.
Scene fitted(const Setup& setup, cv::Size size);

/// The quilt of a photo (from fitted() at the layout's tile size), or a quilt itself.
cv::Mat makeQuilt(const Setup& setup, const Scene& fitted);

/// The size at which a photo becomes a Native: the tile's, or the panel's if the knobs say best.
cv::Size nativeFitSize(const Setup& setup);

/// The Native, exactly as photo2native and quilt2native make it; a Native itself.
/// @param fitted of a photo, at nativeFitSize()
cv::Mat makeNative(const Setup& setup, const Scene& fitted);

/// What can be written of a setup.
enum class Product { Native, Quilt, Views, Depth, SwayVideo };

/// The products that a document has.
std::vector<Product> productsOf(Kind kind);

/// The file that writeProduct() writes for a name: that of a quilt tells its layout.
/// @throws Error Mismatch if a quilt's name says something else
std::filesystem::path productFile(const Setup& setup, Product product,
                                  const std::filesystem::path& target);

/// What a product loses in a file of that name, a sentence each.
std::vector<std::string> lossesOf(Product product, const std::filesystem::path& file);

/// Makes one and writes it.
/// @param target a file, which is replaced if it exists; of views a directory without views
/// @return what was written, for people; empty if the work was cancelled
/// @throws Error; nothing half-written is left
std::string writeProduct(const Setup& setup, Product product, const std::filesystem::path& target,
                         const Progress& progress);

} // namespace altiro3D::viewer
