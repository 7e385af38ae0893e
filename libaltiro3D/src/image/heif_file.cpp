#include "image/heif_file.hpp"

#include "altiro3D/image_io.hpp"
#include "base/image_format.hpp"
#include "base/owned.hpp"
#include "base/text.hpp"

#include <algorithm>
#include <cstdint>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

#ifdef ALTIRO3D_HAVE_HEIF
#include <libheif/heif.h>
#endif

namespace altiro3D {

#ifdef ALTIRO3D_HAVE_HEIF

namespace {

using std::string_view;

constexpr std::size_t kMaxMessage = 120;
constexpr std::size_t kMaxMetadataBytes = std::size_t{16} << 20;

using Image = std::unique_ptr<const heif_image, Free<heif_image_release>>;

void require(const heif_error& error) {
    if (error.code == heif_error_Ok) return;
    if (error.code == heif_error_Memory_allocation_error &&
        error.subcode != heif_suberror_Security_limit_exceeded) {
        throw std::bad_alloc();
    }
    std::string text = error.message != nullptr ? error.message : "no reason given";
    std::replace(text.begin(), text.end(), '\n', ' ');
    throw PictureFailure("libheif: " + text.substr(0, kMaxMessage));
}

// A private copy of a plane; 9 to 15 bits become 16.
cv::Mat planeOf(const heif_image& image, heif_channel channel, int channels) {
    int step = 0;
    const std::uint8_t* const data = heif_image_get_plane_readonly(&image, channel, &step);
    const int columns = heif_image_get_width(&image, channel);
    const int rows = heif_image_get_height(&image, channel);
    const int bits = heif_image_get_bits_per_pixel_range(&image, channel);
    if (data == nullptr || columns < 1 || rows < 1 || bits < 1 || bits > 16 || step < 1) {
        throw PictureFailure("the decoder gave no picture");
    }
    const int type = CV_MAKETYPE(bits > 8 ? CV_16U : CV_8U, channels);
    const cv::Mat plane(rows, columns, type, const_cast<std::uint8_t*>(data),
                        static_cast<std::size_t>(step));
    cv::Mat result;
    if (bits == 8 || bits == 16) {
        plane.copyTo(result);
    } else {
        const double largest = bits > 8 ? 65535 : 255;
        plane.convertTo(result, -1, largest / ((1 << bits) - 1));
    }
    return result;
}

Image decoded(const heif_image_handle& handle, heif_colorspace space, heif_chroma chroma) {
    heif_image* image = nullptr;
    require(heif_decode_image(&handle, &image, space, chroma, nullptr));
    return Image(image);
}

// @throws PictureFailure
void requireSize(const heif_image_handle& handle, const std::string& what, double maxPixels) {
    const double columns = heif_image_handle_get_width(&handle);
    const double rows = heif_image_handle_get_height(&handle);
    if (columns >= 1 && rows >= 1 && columns * rows <= maxPixels) return;
    throw PictureFailure(what + " has " + numberText(columns) + " x " + numberText(rows) + " px");
}

// The picture as BGR or BGRA.
cv::Mat pictureOf(heif_context& context, const heif_image_handle& handle) {
    heif_context_set_max_decoding_threads(&context,
                                          cv::getNumThreads() > 1 ? cv::getNumThreads() : 0);
    const bool alpha = heif_image_handle_has_alpha_channel(&handle) != 0;
    const bool deep = heif_image_handle_get_luma_bits_per_pixel(&handle) > 8;
    const heif_chroma chroma =
        deep ? (alpha ? heif_chroma_interleaved_RRGGBBAA_LE : heif_chroma_interleaved_RRGGBB_LE)
             : (alpha ? heif_chroma_interleaved_RGBA : heif_chroma_interleaved_RGB);
    const Image image = decoded(handle, heif_colorspace_RGB, chroma);
    cv::Mat picture = planeOf(*image, heif_channel_interleaved, alpha ? 4 : 3);
    cv::cvtColor(picture, picture, alpha ? cv::COLOR_RGBA2BGRA : cv::COLOR_RGB2BGR);
    return picture;
}

std::shared_ptr<heif_context> contextOf(string_view bytes, heif_error& error) {
    static const heif_error initialized = heif_init(nullptr); // loads decoders that are plugins
    static_cast<void>(initialized);
    std::shared_ptr<heif_context> context(heif_context_alloc(), heif_context_free);
    if (!context) throw std::bad_alloc();
    error = heif_context_read_from_memory_without_copy(context.get(), bytes.data(), bytes.size(),
                                                       nullptr);
    return context;
}

} // namespace

// @throws PictureFailure (no such picture)
HeifFile::Handle HeifFile::handleOf(std::optional<std::uint32_t> item) const {
    if (!item) return handle_;
    heif_image_handle* opened = nullptr;
    require(heif_context_get_image_handle(context_.get(), *item, &opened));
    return Handle(opened, heif_image_handle_release);
}

bool hasHeif() {
    return true;
}

HeifFile::HeifFile(string_view bytes) {
    heif_error error{};
    context_ = contextOf(bytes, error);
    if (error.code != heif_error_Ok) {
        repaired_ = repairedHeif(bytes);
        if (!repaired_.empty()) context_ = contextOf(repaired_, error);
    }
    require(error);
    const std::string problem = heifProblem(bytes, kMaxImagePixels);
    if (!problem.empty()) throw PictureFailure(problem);
    heif_image_handle* handle = nullptr;
    require(heif_context_get_primary_image_handle(context_.get(), &handle));
    handle_.reset(handle, heif_image_handle_release);
}

cv::Size HeifFile::size() const {
    return {std::max(0, heif_image_handle_get_width(handle_.get())),
            std::max(0, heif_image_handle_get_height(handle_.get()))};
}

unsigned HeifFile::pictures() const {
    const int count = heif_context_get_number_of_top_level_images(context_.get());
    return static_cast<unsigned>(std::max(1, count));
}

std::string HeifFile::iccProfile(std::optional<std::uint32_t> item) const {
    const Handle handle = handleOf(item);
    const heif_color_profile_type type = heif_image_handle_get_color_profile_type(handle.get());
    if (type != heif_color_profile_type_prof && type != heif_color_profile_type_rICC) return {};
    std::string profile(heif_image_handle_get_raw_color_profile_size(handle.get()), '\0');
    if (profile.empty() || profile.size() > kMaxMetadataBytes) return {};
    require(heif_image_handle_get_raw_color_profile(handle.get(), profile.data()));
    return profile;
}

std::optional<ColourCode> HeifFile::colours(std::optional<std::uint32_t> item) const {
    const Handle handle = handleOf(item);
    heif_color_profile_nclx* nclx = nullptr;
    const heif_error error = heif_image_handle_get_nclx_color_profile(handle.get(), &nclx);
    if (error.code != heif_error_Ok || nclx == nullptr) return std::nullopt;
    const ColourCode colours{nclx->color_primaries, nclx->transfer_characteristics};
    heif_nclx_color_profile_free(nclx);
    return colours;
}

std::string HeifFile::exif() const {
    constexpr std::size_t kOffset = 4; // of the EXIF in its block; writers give 0 or 6
    heif_item_id id = 0;
    if (heif_image_handle_get_list_of_metadata_block_IDs(handle_.get(), "Exif", &id, 1) < 1)
        return {};
    std::string block(heif_image_handle_get_metadata_size(handle_.get(), id), '\0');
    if (block.size() <= kOffset || block.size() > kMaxMetadataBytes) return {};
    const heif_error error = heif_image_handle_get_metadata(handle_.get(), id, block.data());
    return error.code == heif_error_Ok ? block.substr(kOffset) : std::string();
}

bool HeifFile::isPremultiplied() const {
    return heif_image_handle_is_premultiplied_alpha(handle_.get()) != 0;
}

cv::Mat HeifFile::decode(std::optional<std::uint32_t> item) const {
    const Handle handle = handleOf(item);
    if (item) requireSize(*handle, "its picture " + std::to_string(*item), kMaxImagePixels);
    return pictureOf(*context_, *handle);
}

std::optional<HeifDepth> HeifFile::decodeDepth(double maxPixels) const {
    const heif_image_handle* const photo = handle_.get();
    heif_item_id id = 0;
    if (heif_image_handle_get_list_of_depth_image_IDs(photo, &id, 1) < 1) return std::nullopt;
    heif_image_handle* opened = nullptr;
    require(heif_image_handle_get_depth_image_handle(photo, id, &opened));
    const Handle handle(opened, heif_image_handle_release);
    requireSize(*handle, "its depth image", maxPixels);
    HeifDepth depth;
    const Image image = decoded(*handle, heif_colorspace_undefined, heif_chroma_undefined);
    const bool isRgb = heif_image_get_colorspace(image.get()) == heif_colorspace_RGB;
    depth.samples = planeOf(*image, isRgb ? heif_channel_G : heif_channel_Y, 1);
    const heif_depth_representation_info* info = nullptr;
    if (heif_image_handle_get_depth_image_representation_info(photo, id, &info) != 0 &&
        info != nullptr) {
        depth.part.isDistance =
            info->depth_representation_type == heif_depth_representation_type_uniform_Z;
        if (info->has_z_near != 0) depth.part.nearest = info->z_near;
        if (info->has_z_far != 0) depth.part.farthest = info->z_far;
        heif_depth_representation_info_free(info);
    }
    depth.part.isNearBright = !depth.part.isDistance;
    return depth;
}

#else // without libheif: every file fails

bool hasHeif() {
    return false;
}

HeifFile::HeifFile(std::string_view /*bytes*/) {
    throw PictureFailure("this build has no libheif");
}

cv::Size HeifFile::size() const {
    return {};
}

unsigned HeifFile::pictures() const {
    return 1;
}

std::string HeifFile::iccProfile(std::optional<std::uint32_t> /*item*/) const {
    return {};
}

std::optional<ColourCode> HeifFile::colours(std::optional<std::uint32_t> /*item*/) const {
    return std::nullopt;
}

std::string HeifFile::exif() const {
    return {};
}

bool HeifFile::isPremultiplied() const {
    return false;
}

cv::Mat HeifFile::decode(std::optional<std::uint32_t> /*item*/) const {
    return {};
}

std::optional<HeifDepth> HeifFile::decodeDepth(double /*maxPixels*/) const {
    return std::nullopt;
}

#endif

} // namespace altiro3D
