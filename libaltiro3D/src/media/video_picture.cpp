#include "media/video_picture.hpp"

#include "altiro3D/enum_table.hpp"
#include "altiro3D/error.hpp"
#include "image/exif.hpp"

#include <cstring>
#include <iterator>
#include <opencv2/imgproc.hpp>
#include <optional>

extern "C" {
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
}

namespace altiro3D {

namespace {

constexpr int kLinesOfStandardDefinition = 576;

// Position of chroma relative to luma samples, in swscale's 1/256 px; -513 = its default.
struct ChromaPlace {
    int x = -513;
    int y = -513;
};

// By default, MPEG video has chroma at the left of two columns, JPEG in the middle.
ChromaPlace chromaPlace(AVPixelFormat format, AVChromaLocation location) {
    const AVPixFmtDescriptor* const shape = av_pix_fmt_desc_get(format);
    ChromaPlace place;
    if (shape == nullptr || shape->nb_components < 3 || shape->log2_chroma_w != 1) return place;
    constexpr ChromaPlace kPlaces[] = {{0, 128}, {0, 128}, {128, 128}, {0, 0},
                                       {128, 0}, {0, 256}, {128, 256}}; // in FFmpeg's order
    const auto index = static_cast<std::size_t>(numberOf(location));
    place = kPlaces[index < std::size(kPlaces) ? index : 0];
    if (shape->log2_chroma_h != 1) place.y = -513;
    return place;
}

ScalerPtr makeScaler(cv::Size from, int fromFormat, ChromaPlace fromPlace, cv::Size to,
                     int toFormat, ChromaPlace toPlace, int threads) {
    ScalerPtr scaler(sws_alloc_context());
    checkMemory(scaler.get());
    const auto set = [&](const char* name, std::int64_t value) {
        av_opt_set_int(scaler.get(), name, value, 0);
    };
    set("srcw", from.width);
    set("srch", from.height);
    set("src_format", fromFormat);
    set("dstw", to.width);
    set("dsth", to.height);
    set("dst_format", toFormat);
    set("src_h_chr_pos", fromPlace.x);
    set("src_v_chr_pos", fromPlace.y);
    set("dst_h_chr_pos", toPlace.x);
    set("dst_v_chr_pos", toPlace.y);
    set("threads", threads);
    set("sws_flags",
        SWS_BICUBIC | SWS_ACCURATE_RND | SWS_FULL_CHR_H_INT | SWS_FULL_CHR_H_INP | SWS_BITEXACT);
    if (sws_init_context(scaler.get(), nullptr, nullptr) < 0) return nullptr;
    return scaler;
}

void setColours(SwsContext* scaler, ColourMatrix from, bool fromFull, ColourMatrix to,
                bool toFull) {
    constexpr int kOne = 1 << 16;
    sws_setColorspaceDetails(scaler, sws_getCoefficients(colourSpace(from)), fromFull ? 1 : 0,
                             sws_getCoefficients(colourSpace(to)), toFull ? 1 : 0, 0, kOne, kOne);
}

// Wraps the memory of a picture in a frame; the picture must outlive it.
FramePtr frameOver(cv::Mat& picture) {
    FramePtr frame = newFrame();
    frame->format = picture.type() == CV_16UC1   ? AV_PIX_FMT_GRAY16
                    : picture.type() == CV_16UC3 ? AV_PIX_FMT_BGR48
                    : picture.type() == CV_16UC4 ? AV_PIX_FMT_BGRA64
                                                 : AV_PIX_FMT_BGR24;
    frame->width = picture.cols;
    frame->height = picture.rows;
    frame->data[0] = picture.data;
    frame->linesize[0] = static_cast<int>(picture.step);
    frame->buf[0] = av_buffer_create(
        picture.data, picture.step * static_cast<std::size_t>(picture.rows),
        [](void*, std::uint8_t*) {}, nullptr, 0);
    checkMemory(frame->buf[0]);
    return frame;
}

bool isHdr(const VideoColour& stored) {
    return stored.transfer == AVCOL_TRC_SMPTE2084 || stored.transfer == AVCOL_TRC_ARIB_STD_B67;
}

// Whether pictures are converted to sRGB: those of wide gamut, HDR or linear light.
bool isConverted(const VideoColour& stored) {
    return isHdr(stored) || stored.transfer == AVCOL_TRC_LINEAR ||
           stored.primaries == AVCOL_PRI_BT2020 || stored.primaries == AVCOL_PRI_SMPTE431 ||
           stored.primaries == AVCOL_PRI_SMPTE432;
}

// Multiplies a row of px by their alpha. @param step from one alpha to the next
void composeOverBlack(const std::uint8_t* alpha, int step, int columns, std::uint8_t* bgr) {
    for (int x = 0; x < columns; ++x, alpha += step, bgr += 3) {
        for (int c = 0; c < 3; ++c)
            bgr[c] = static_cast<std::uint8_t>((bgr[c] * *alpha + 127) / 255);
    }
}

} // namespace

void setRotation(VideoFacts& facts, const std::int32_t* displayMatrix) {
    if (displayMatrix == nullptr) return;
    // x' = a x + c y, y' = b x + d y: transposed first, then mirrored
    const std::int64_t a = displayMatrix[0];
    const std::int64_t b = displayMatrix[1];
    const std::int64_t c = displayMatrix[3];
    const std::int64_t d = displayMatrix[4];
    const bool transposes = std::llabs(b) + std::llabs(c) > std::llabs(a) + std::llabs(d);
    const bool mirrorsColumns = (transposes ? c : a) < 0;
    const bool mirrorsRows = (transposes ? b : d) < 0;
    facts.mirrored = transposes != (mirrorsColumns != mirrorsRows);
    const bool turnsColumns = mirrorsColumns != facts.mirrored; // by the rotation alone
    facts.rotationDegrees = transposes ? (turnsColumns ? 90 : 270) : (turnsColumns ? 180 : 0);
}

int orientationOf(const VideoFacts& facts) {
    constexpr int kExif[4][2] = {{1, 2}, {6, 5}, {3, 4}, {8, 7}};
    return kExif[facts.rotationDegrees / 90][facts.mirrored ? 1 : 0];
}

VideoColour videoColour(AVPixelFormat format, int matrix, int range, int primaries, int transfer,
                        int rows) {
    VideoColour colour;
    if (primaries > 0 && primaries < AVCOL_PRI_NB) colour.primaries = primaries;
    if (transfer > 0 && transfer < AVCOL_TRC_NB) colour.transfer = transfer;
    const AVPixFmtDescriptor* const shape = av_pix_fmt_desc_get(format);
    const bool rgb = shape != nullptr && (shape->flags & AV_PIX_FMT_FLAG_RGB) != 0;
    const auto isOneOf = [&](auto... codes) { return ((matrix == codes) || ...); };
    std::optional<ColourMatrix> stated;
    if (isOneOf(AVCOL_SPC_BT709, AVCOL_SPC_SMPTE240M)) stated = ColourMatrix::Bt709; // or nearest
    if (isOneOf(AVCOL_SPC_FCC, AVCOL_SPC_BT470BG, AVCOL_SPC_SMPTE170M))
        stated = ColourMatrix::Bt601;
    if (isOneOf(AVCOL_SPC_BT2020_NCL, AVCOL_SPC_BT2020_CL)) stated = ColourMatrix::Bt2020;
    if (rgb) stated = ColourMatrix::Rgb;
    // the planes may be Y, U and V and stated as RGB
    const bool isHigh = matrix == AVCOL_SPC_RGB || rows > kLinesOfStandardDefinition;
    colour.stated = stated.has_value();
    colour.matrix = stated.value_or(isHigh ? ColourMatrix::Bt709 : ColourMatrix::Bt601);
    const bool jpeg = format == AV_PIX_FMT_YUVJ420P || format == AV_PIX_FMT_YUVJ422P ||
                      format == AV_PIX_FMT_YUVJ444P || format == AV_PIX_FMT_YUVJ440P ||
                      format == AV_PIX_FMT_YUVJ411P;
    const bool full = jpeg || range == AVCOL_RANGE_JPEG || rgb;
    colour.range = full ? ColourRange::Full : ColourRange::Limited;
    return colour;
}

VideoColour shownColour(const VideoColour& stored) {
    if (!isConverted(stored)) return stored;
    VideoColour shown;
    shown.stated = true;
    shown.primaries = AVCOL_PRI_BT709;
    shown.transfer = AVCOL_TRC_BT709;
    return shown;
}

AVColorSpace colourSpace(ColourMatrix matrix) {
    constexpr AVColorSpace kSpaces[] = {AVCOL_SPC_RGB, AVCOL_SPC_SMPTE170M, AVCOL_SPC_BT709,
                                        AVCOL_SPC_BT2020_NCL};
    return entryOf(kSpaces, matrix);
}

AVColorRange colourRange(ColourRange range) {
    return range == ColourRange::Full ? AVCOL_RANGE_JPEG : AVCOL_RANGE_MPEG;
}

PictureMaker::PictureMaker(int orientation, bool isDepth, int threads, std::string subject)
    : orientation_(orientation), isDepth_(isDepth), threads_(threads),
      subject_(std::move(subject)) {}

void PictureMaker::prepare(const AVFrame& frame) {
    const cv::Size size(frame.width, frame.height);
    const auto format = static_cast<AVPixelFormat>(frame.format);
    if (rows_ == 0) rows_ = frame.height;
    const VideoColour colour =
        videoColour(format, numberOf(frame.colorspace), numberOf(frame.color_range),
                    numberOf(frame.color_primaries), numberOf(frame.color_trc), rows_);
    const bool isSameLight =
        colour.primaries == colour_.primaries && colour.transfer == colour_.transfer;
    if (scaler_ && size == size_ && format == format_ && colour.matrix == colour_.matrix &&
        colour.range == colour_.range && isSameLight && frame.chroma_location == chromaLocation_) {
        return;
    }
    const AVPixFmtDescriptor* const shape = av_pix_fmt_desc_get(format);
    const bool isGrey = shape != nullptr && shape->nb_components == 1 && shape->comp[0].depth > 8;
    hasAlpha_ = !isDepth_ && shape != nullptr && (shape->flags & AV_PIX_FMT_FLAG_ALPHA) != 0;
    if (!isSameLight) {
        table_ =
            isConverted(colour) ? ColourTable(colour.primaries, colour.transfer) : ColourTable();
    }
    if (isDepth_ && isGrey) {
        way_ = Way::Grey;
    } else if (!isDepth_ && isConverted(colour)) {
        way_ = Way::Deep;
        deep_.create(size, hasAlpha_ ? CV_16UC4 : CV_16UC3);
        if (isHdr(colour)) hdrTransfer_ = colour.transfer;
    } else if (colour.matrix != ColourMatrix::Rgb && shape != nullptr &&
               shape->nb_components >= 3) {
        way_ = Way::Planes;
    } else {
        way_ = Way::Direct;
        if (hasAlpha_) mixed_.create(size, CV_8UC4);
    }
    const AVPixelFormat target =
        way_ == Way::Grey     ? AV_PIX_FMT_GRAY16
        : way_ == Way::Planes ? (hasAlpha_ ? AV_PIX_FMT_YUVA444P : AV_PIX_FMT_YUV444P)
        : way_ == Way::Direct ? (hasAlpha_ ? AV_PIX_FMT_BGRA : AV_PIX_FMT_BGR24)
        : hasAlpha_           ? AV_PIX_FMT_BGRA64
                              : AV_PIX_FMT_BGR48;
    scaler_ = sws_isSupportedInput(format) != 0
                  ? makeScaler(size, format, chromaPlace(format, frame.chroma_location), size,
                               target, {}, threads_)
                  : nullptr;
    if (!scaler_) {
        const char* const name = av_get_pix_fmt_name(format);
        throw Error(ErrorCode::Unsupported, subject_,
                    std::string("has pictures of the format ") +
                        (name != nullptr ? name : "unknown") + ", expected one that can be read");
    }
    const bool full = colour.range == ColourRange::Full || way_ == Way::Grey;
    setColours(scaler_.get(), colour.matrix, full, colour.matrix, full || way_ != Way::Planes);
    if (way_ == Way::Planes) {
        weights_ = bgrWeights(colour.matrix, colour.range);
        planes_ = newFrame(target, size.width, size.height);
    }
    chromaLocation_ = frame.chroma_location;
    size_ = size;
    format_ = format;
    colour_ = colour;
}

void PictureMaker::scale(const AVFrame& frame, AVFrame& to) {
    const int result = sws_scale_frame(scaler_.get(), &to, &frame);
    if (result >= 0) return;
    throw Error(result == AVERROR(ENOMEM) ? ErrorCode::OutOfMemory : ErrorCode::ReadFailed,
                subject_, "a frame cannot be converted to BGR: " + ffmpegText(result));
}

// Converts the frame without rotation. prepare() must have been called for it.
void PictureMaker::convert(const AVFrame& frame, cv::Mat& picture) {
    picture.create(size_, way_ == Way::Grey ? CV_16UC1 : CV_8UC3);
    const bool isMixed = way_ == Way::Direct && hasAlpha_;
    if (isMixed) {
        scale(frame, *frameOver(mixed_));
        cv::cvtColor(mixed_, picture, cv::COLOR_BGRA2BGR);
    } else if (way_ == Way::Direct || way_ == Way::Grey) {
        scale(frame, *frameOver(picture));
        return;
    }
    const auto overRows = [&](const auto& work) {
        cv::parallel_for_(
            cv::Range(0, size_.height),
            [&](const cv::Range& rows) {
                for (int row = rows.start; row < rows.end; ++row)
                    work(row, picture.ptr<std::uint8_t>(row));
            },
            threads_);
    };
    if (isMixed) {
        overRows([&](int row, std::uint8_t* to) {
            composeOverBlack(mixed_.ptr<std::uint8_t>(row) + 3, 4, size_.width, to);
        });
        return;
    }
    if (way_ == Way::Deep) {
        scale(frame, *frameOver(deep_));
        overRows([&](int row, std::uint8_t* to) {
            table_.row(deep_.ptr<std::uint16_t>(row), deep_.channels(), size_.width, to);
        });
        return;
    }
    const bool isWhole = format_ == AV_PIX_FMT_YUV444P || format_ == AV_PIX_FMT_YUVJ444P ||
                         (hasAlpha_ && format_ == AV_PIX_FMT_YUVA444P);
    if (!isWhole) scale(frame, *planes_);
    const AVFrame& planes = isWhole ? frame : *planes_;
    overRows([&](int row, std::uint8_t* to) {
        const auto plane = [&](int p) {
            return planes.data[p] + static_cast<std::ptrdiff_t>(row) * planes.linesize[p];
        };
        yuvToBgr(plane(0), plane(1), plane(2), static_cast<std::size_t>(size_.width), weights_, to);
        if (hasAlpha_) composeOverBlack(plane(3), 1, size_.width, to);
    });
}

void PictureMaker::make(const AVFrame& frame, cv::Mat& picture) {
    prepare(frame);
    convert(frame, orientation_ == 1 ? picture : unturned_);
    if (orientation_ != 1) picture = upright(unturned_, orientation_);
}

FrameMaker::FrameMaker(AVPixelFormat format, cv::Size size, ColourMatrix matrix, ColourRange range,
                       int threads)
    : format_(format), size_(size), threads_(threads) {
    if (format == AV_PIX_FMT_YUV444P || format == AV_PIX_FMT_YUV444P10) {
        weights_ = yuvWeights(matrix, range, format == AV_PIX_FMT_YUV444P ? 8 : 10);
    } else if (format == AV_PIX_FMT_YUV420P) {
        scaler_ = makeScaler(size, AV_PIX_FMT_BGR24, {}, size, format,
                             chromaPlace(format, AVCHROMA_LOC_LEFT), threads);
        checkMemory(scaler_.get());
        setColours(scaler_.get(), matrix, true, matrix, range == ColourRange::Full);
    }
}

AVFrame& FrameMaker::freeFrame() {
    for (const FramePtr& frame : frames_) {
        if (av_frame_is_writable(frame.get()) > 0) return *frame;
    }
    return *frames_.emplace_back(newFrame(format_, size_.width, size_.height));
}

AVFrame& FrameMaker::make(const cv::Mat& picture) {
    AVFrame& frame = freeFrame();
    const auto width = static_cast<std::size_t>(size_.width);
    if (scaler_) {
        cv::Mat header = picture;
        const FramePtr source = frameOver(header);
        const int result = sws_scale_frame(scaler_.get(), &frame, source.get());
        if (result < 0) {
            throw Error(ErrorCode::OutOfMemory, "video",
                        "a frame cannot be converted: " + ffmpegText(result));
        }
        return frame;
    }
    if (format_ == AV_PIX_FMT_BGR0) {
        cv::Mat to(size_, CV_8UC4, frame.data[0], static_cast<std::size_t>(frame.linesize[0]));
        cv::cvtColor(picture, to, cv::COLOR_BGR2BGRA);
        return frame;
    }
    const auto convertRows = [&](const cv::Range& rows) {
        for (int row = rows.start; row < rows.end; ++row) {
            const auto* const from = picture.ptr<std::uint8_t>(row);
            const auto plane = [&](int p) {
                return frame.data[p] + static_cast<std::ptrdiff_t>(row) * frame.linesize[p];
            };
            if (format_ == AV_PIX_FMT_BGR24) {
                std::memcpy(plane(0), from, 3 * width);
            } else if (format_ == AV_PIX_FMT_YUV444P) {
                bgrToYuv(from, width, weights_, plane(0), plane(1), plane(2));
            } else {
                bgrToYuv(from, width, weights_, reinterpret_cast<std::uint16_t*>(plane(0)),
                         reinterpret_cast<std::uint16_t*>(plane(1)),
                         reinterpret_cast<std::uint16_t*>(plane(2)));
            }
        }
    };
    cv::parallel_for_(cv::Range(0, size_.height), convertRows, threads_);
    return frame;
}

} // namespace altiro3D
