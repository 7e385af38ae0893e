#include "media/frame_decoder.hpp"

#include "altiro3D/error.hpp"
#include "base/system_library.hpp"

#include <algorithm>
#include <utility>

extern "C" {
#include <libavutil/imgutils.h>
#include <libavutil/pixdesc.h>

#include <libavfilter/buffersink.h>
#include <libavfilter/buffersrc.h>
}

namespace altiro3D {

namespace {

constexpr const char* kFilters = "libavfilter.so." AV_STRINGIFY(LIBAVFILTER_VERSION_MAJOR);

#ifdef ALTIRO3D_LINKS_ALL_FFMPEG
#define ALTIRO3D_FILTER(name) name
#else
#define ALTIRO3D_FILTER(name) load(#name)
#endif

// The functions of libavfilter. Loaded with the first interlaced frame, not linked: its libraries
// would take a fifth of every program's start-up time.
class Filters {
  public:
    static const Filters& get() {
        static const Filters filters;
        return filters;
    }

    bool areThere = true;
    decltype(&avfilter_graph_alloc) allocGraph = ALTIRO3D_FILTER(avfilter_graph_alloc);
    decltype(&avfilter_graph_free) freeGraph = ALTIRO3D_FILTER(avfilter_graph_free);
    decltype(&avfilter_graph_parse_ptr) parse = ALTIRO3D_FILTER(avfilter_graph_parse_ptr);
    decltype(&avfilter_graph_config) config = ALTIRO3D_FILTER(avfilter_graph_config);
    decltype(&avfilter_graph_get_filter) filterOf = ALTIRO3D_FILTER(avfilter_graph_get_filter);
    decltype(&av_buffersrc_add_frame) addFrame = ALTIRO3D_FILTER(av_buffersrc_add_frame);
    decltype(&av_buffersink_get_frame) getFrame = ALTIRO3D_FILTER(av_buffersink_get_frame);
    decltype(&av_buffersink_get_time_base) timeBaseOf =
        ALTIRO3D_FILTER(av_buffersink_get_time_base);

  private:
    struct Symbol {
        void* address;
        template <class Function>
        operator Function*() const { // NOLINT(google-explicit-constructor)
            return reinterpret_cast<Function*>(address);
        }
    };
    [[maybe_unused]] Symbol load(const char* name) {
        static void* const library = openLibrary(kFilters);
        void* const address = addressIn(library, name);
        areThere = areThere && address != nullptr;
        return {address};
    }
};

bool isInterlaced(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(58, 7, 100)
    return (frame.flags & AV_FRAME_FLAG_INTERLACED) != 0;
#else
    return frame.interlaced_frame != 0;
#endif
}

bool areAlike(const AVFrame& a, const AVFrame& b) {
    return a.width == b.width && a.height == b.height && a.format == b.format;
}

// Another reference to the same picture.
void copyReference(const AVFrame& from, AVFrame& to) {
    av_frame_unref(&to);
    checkRoom(av_frame_ref(&to, &from));
}

// Whether a picture of spatial video shows the right eye: by HEVC's message, else by its layer.
bool isOfRightEye(const AVFrame& frame) {
#if LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(61, 19, 100)
    const AVFrameSideData* const side = av_frame_get_side_data(&frame, AV_FRAME_DATA_STEREO3D);
    const int view =
        side != nullptr ? numberOf(reinterpret_cast<const AVStereo3D*>(side->data)->view) : 0;
    if (view == AV_STEREO3D_VIEW_LEFT || view == AV_STEREO3D_VIEW_RIGHT)
        return view == AV_STEREO3D_VIEW_RIGHT;
    const AVFrameSideData* const id = av_frame_get_side_data(&frame, AV_FRAME_DATA_VIEW_ID);
    return id != nullptr && *reinterpret_cast<const int*>(id->data) != 0;
#else
    return frame.data[0] == nullptr; // never: this FFmpeg decodes one eye of spatial video only
#endif
}

// Whether a frame is the second of an alternating pair; nothing if it does not say so.
std::optional<bool> isSecond(const AVFrame& frame) {
    const AVFrameSideData* const side = av_frame_get_side_data(&frame, AV_FRAME_DATA_STEREO3D);
    if (side == nullptr) return std::nullopt;
    const int view = numberOf(reinterpret_cast<const AVStereo3D*>(side->data)->view);
    if (view == AV_STEREO3D_VIEW_PACKED) return std::nullopt;
    return view == AV_STEREO3D_VIEW_RIGHT;
}

// Copies a picture into one of twice its width.
void copyHalf(const AVFrame& from, bool isRight, AVFrame& to) {
    const auto format = static_cast<AVPixelFormat>(from.format);
    const AVPixFmtDescriptor* const description = av_pix_fmt_desc_get(format);
    for (int plane = 0; plane < av_pix_fmt_count_planes(format); ++plane) {
        const bool isChroma = plane == 1 || plane == 2;
        const int bytes = av_image_get_linesize(format, from.width, plane);
        const int shift = isChroma ? description->log2_chroma_h : 0;
        av_image_copy_plane(to.data[plane] + (isRight ? bytes : 0), to.linesize[plane],
                            from.data[plane], from.linesize[plane], bytes,
                            -(-from.height >> shift));
    }
}

constexpr int kMaxInDisorder = 16; // frames; beyond this the times have jumped
constexpr double kFarBackSeconds = 1;

std::int64_t nominalDuration(const VideoFacts& facts, AVRational unit) {
    const Fraction& rate = facts.averageRate.isKnown() ? facts.averageRate : facts.nominalRate;
    if (!rate.isKnown()) return 0;
    const std::int64_t duration =
        av_rescale_q(1, AVRational{rate.denominator, rate.numerator}, unit);
    return std::clamp<std::int64_t>(duration, 0, kFarthestTime);
}

} // namespace

void FreeGraph::operator()(AVFilterGraph* graph) const {
    // NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): a graph exists only with the functions
    Filters::get().freeGraph(&graph);
}

Deinterlacer::Deinterlacer(AVRational unit, int threads, std::string subject)
    : unit_(unit), threads_(threads), subject_(std::move(subject)) {}

void Deinterlacer::restart() {
    graph_.reset();
    last_.reset();
    skips_ = false;
    ready_.clear();
}

void Deinterlacer::open(const AVFrame& frame) {
    const auto fail = [this](const std::string& why) {
        throw Error(ErrorCode::Unsupported, subject_,
                    "has interlaced frames that cannot be deinterlaced: " + why +
                        ", expected them to be left as they are");
    };
    const Filters& filters = Filters::get();
    if (!filters.areThere) fail(std::string(kFilters) + " is missing");
    graph_.reset(filters.allocGraph());
    checkMemory(graph_.get());
    graph_->nb_threads = threads_;
    const std::string chain =
        "buffer@in=video_size=" + std::to_string(frame.width) + "x" + std::to_string(frame.height) +
        ":pix_fmt=" + std::to_string(frame.format) + ":time_base=" + std::to_string(unit_.num) +
        "/" + std::to_string(unit_.den) +
        ",bwdif=mode=send_frame:parity=auto:deint=interlaced,buffersink@out";
    int result = filters.parse(graph_.get(), chain.c_str(), nullptr, nullptr, nullptr);
    if (result >= 0) result = filters.config(graph_.get(), nullptr);
    if (result < 0) fail("FFmpeg's filter bwdif fails: " + ffmpegText(result));
    source_ = filters.filterOf(graph_.get(), "buffer@in");
    sink_ = filters.filterOf(graph_.get(), "buffersink@out");
}

// Passes a frame, or null for the end, to the graph and collects what it delivers.
void Deinterlacer::push(const DecodedFrame* decoded) {
    FramePtr frame;
    if (decoded != nullptr) {
        frame = newFrame();
        copyReference(*decoded->frame, *frame);
        frame->pts = decoded->pts;
    }
    const Filters& filters = Filters::get();
    checkRoom(filters.addFrame(source_, frame.get()));
    for (;;) {
        DecodedFrame made;
        if (filters.getFrame(sink_, made.frame.get()) < 0) return; // at the end, or too few
        made.pts = av_rescale_q(made.frame->pts, filters.timeBaseOf(sink_), unit_);
        if (!std::exchange(skips_, false)) ready_.push_back(std::move(made));
    }
}

void Deinterlacer::give(DecodedFrame& decoded) {
    const AVFrame& frame = *decoded.frame;
    const bool isAlike = last_ && areAlike(*last_->frame, frame);
    if (graph_ && !isAlike) { // the filter needs frames of one size
        push(nullptr);
        graph_.reset();
    }
    if (graph_) {
        push(&decoded);
    } else if (!isInterlaced(frame)) {
        DecodedFrame& passed = ready_.emplace_back();
        copyReference(frame, *passed.frame);
        passed.pts = decoded.pts;
    } else {
        open(frame);
        if (isAlike) {
            skips_ = true;
            push(&*last_);
        }
        push(&decoded);
    }
    if (!last_) last_.emplace();
    copyReference(frame, *last_->frame);
    last_->pts = decoded.pts;
}

void Deinterlacer::end() {
    if (graph_) push(nullptr);
    graph_.reset();
    last_.reset();
}

bool Deinterlacer::take(DecodedFrame& decoded) {
    if (ready_.empty()) return false;
    std::swap(decoded, ready_.front());
    ready_.pop_front();
    return true;
}

bool EyesJoiner::join(AVFrame& frame, bool isOfTwin) {
    if (std::exchange(skips_, false)) return false;
    const bool isEven = frame.width % 2 == 0; // as in all files that phones write
    const auto place = turns_.alternate ? isSecond(frame) : std::nullopt;
    const bool isRight = turns_.alternate ? !turns_.rightFirst : isOfTwin || isOfRightEye(frame);
    const auto leaveOut = [this] {
        waiting_.pop_front();
        ++lost_;
    };
    if (turns_.alternate) {
        if (!waiting_.empty() && (!areAlike(*waiting_.front(), frame) || !place.value_or(true)))
            waiting_.clear();
    } else if (isRight != isRightWaiting_) {
        while (!waiting_.empty() && (waiting_.front()->pts + turns_.mostDistance < frame.pts ||
                                     !areAlike(*waiting_.front(), frame) || !isEven))
            leaveOut();
        if (!waiting_.empty() && waiting_.front()->pts > frame.pts + turns_.mostDistance) {
            ++lost_;
            return false;
        }
    } else if (waiting_.size() >= turns_.mostWaiting) {
        leaveOut();
    }
    if (waiting_.empty() || (!turns_.alternate && isRight == isRightWaiting_)) {
        if (place.value_or(false)) return false; // the first one is missing
        waiting_.push_back(newFrame());
        av_frame_move_ref(waiting_.back().get(), &frame);
        isRightWaiting_ = isRight;
        return false;
    }
    const AVFrame& first = *waiting_.front();
    FramePtr made;
    if (turns_.leftAlone) {
        made = newFrame();
        copyReference(isRight ? first : frame, *made);
        made->pts = first.pts;
        made->best_effort_timestamp = first.best_effort_timestamp;
    } else {
        made = newFrame(frame.format, 2 * frame.width, frame.height);
        copyHalf(first, !isRight, *made);
        copyHalf(frame, isRight, *made);
        checkRoom(av_frame_copy_props(made.get(), &first));
    }
    if (turns_.alternate) { // up to the next pair
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(57, 30, 100)
        made->duration = 0;
#else
        made->pkt_duration = 0;
#endif
    }
    waiting_.pop_front();
    av_frame_unref(&frame);
    av_frame_move_ref(&frame, made.get());
    return true;
}

void EyesJoiner::skip() {
    skips_ = turns_.alternate && waiting_.empty();
    if (turns_.alternate) waiting_.clear();
}

FrameTimes::FrameTimes(const VideoFacts& facts, AVRational unit, std::int64_t start,
                       VideoReadCounts& counts)
    : unit_(unit), start_(start), frameDuration_(nominalDuration(facts, unit)),
      countsFirst_(!facts.averageRate.isKnown() || facts.frameCount.value_or(0) > 1),
      counts_(counts) {}

void FrameTimes::restart() {
    last_.reset();
    shift_ = 0;
    inDisorder_ = 0;
    beginsAgain_ = false;
}

std::int64_t FrameTimes::next(const AVFrame& frame) {
    last_ = risingTime(frame);
    return *last_;
}

std::int64_t FrameTimes::risingTime(const AVFrame& frame) {
    std::optional<std::int64_t> stated; // AV_NOPTS_VALUE is far outside
    if (isNear(frame.best_effort_timestamp)) stated = frame.best_effort_timestamp;
    if (stated && (!last_ || *stated > *last_)) shift_ = 0;
    const std::int64_t latest = kFarthestTime;
    if (stated && (!last_ || *stated + shift_ > *last_)) {
        inDisorder_ = 0;
        return std::min(*stated + shift_, latest);
    }
    if (last_ || countsFirst_) ++counts_.repairedTimes;
    if (!last_) return start_;
    const std::int64_t step = std::max<std::int64_t>(frameDuration_, 1);
    const std::int64_t next = std::min(*last_ + step, latest);
    if (!stated) return next;
    // A piece begins with a key frame.
    const std::int64_t back = *last_ - *stated - shift_;
    const bool isPiece = frame.pict_type == AV_PICTURE_TYPE_I && back >= 2 * step;
    const double seconds = static_cast<double>(back) * av_q2d(unit_);
    const bool isFar = seconds >= kFarBackSeconds && back >= kMaxInDisorder * step;
    if (++inDisorder_ <= kMaxInDisorder && !isPiece && !isFar) return std::min(*last_ + 1, latest);
    beginsAgain_ = beginsAgain_ || isPiece || isFar;
    shift_ = next - *stated;
    return next;
}

FrameDecoder::FrameDecoder(VideoInput& input, const VideoReaderOptions& options,
                           VideoPackets& packets, VideoReadCounts& counts)
    : decoder_(std::move(input.decoder)), twinDecoder_(std::move(input.twinDecoder)),
      twin_(input.twin), unit_(input.stream->time_base), packets_(packets),
      times_(input.facts, unit_, input.startPts, counts), counts_(counts) {
    EyesJoiner::Turns turns{input.alternates, input.rightFirst, !input.joinsEyes};
    if (twin_ != nullptr) turns.mostWaiting = 50;
    if (twin_ != nullptr) turns.mostDistance = times_.frameDuration() / 2;
    if (input.joinsEyes || input.alternates) joiner_.emplace(turns);
    if (options.deinterlace) deinterlacer_.emplace(unit_, options.threads, input.subject);
}

void FrameDecoder::restart() {
    avcodec_flush_buffers(decoder_.get());
    if (twinDecoder_) avcodec_flush_buffers(twinDecoder_.get());
    corruptPts_.clear();
    sentEnd_ = false;
    times_.restart();
    if (joiner_) joiner_->restart();
    if (deinterlacer_) deinterlacer_->restart();
}

bool FrameDecoder::deinterlaces() const {
    return deinterlacer_ && (interlaced_ || numberOf(decoder_->field_order) > AV_FIELD_PROGRESSIVE);
}

bool FrameDecoder::decode(DecodedFrame& decoded) {
    if (!deinterlacer_) return decodeNext(decoded);
    while (!deinterlacer_->take(decoded)) {
        if (decodeNext(given_)) {
            deinterlacer_->give(given_);
            continue;
        }
        deinterlacer_->end();
        return deinterlacer_->take(decoded);
    }
    return true;
}

bool FrameDecoder::decodeNext(DecodedFrame& decoded) {
    AVFrame& frame = *decoded.frame;
    for (;;) {
        int result = avcodec_receive_frame(decoder_.get(), &frame);
        const bool isOfTwin = twinDecoder_ && (result == AVERROR_EOF || result == AVERROR(EAGAIN));
        if (isOfTwin) result = avcodec_receive_frame(twinDecoder_.get(), &frame);
        if (result == AVERROR_EOF) {
            if (twin_ != nullptr) counts_.corrupt += static_cast<int>(joiner_->restart());
            return false;
        }
        if (result == AVERROR(EAGAIN)) {
            if (!feed()) return false;
            continue;
        }
        if (result == AVERROR(ENOMEM)) checkMemory(nullptr);
        if (result < 0 || isDamaged(frame)) {
            ++counts_.corrupt;
            if (joiner_) joiner_->skip();
            continue;
        }
        if (joiner_) {
            if (twin_ != nullptr) {
                const std::int64_t time = frame.best_effort_timestamp;
                const AVRational unit = isOfTwin ? twin_->time_base : unit_;
                frame.pts = isNear(time) ? av_rescale_q(time, unit, unit_) : 0;
                frame.best_effort_timestamp = frame.pts;
            }
            const bool isWhole = joiner_->join(frame, isOfTwin);
            counts_.corrupt += joiner_->takeLost();
            if (!isWhole) continue;
        }
        interlaced_ = interlaced_ || isInterlaced(frame);
        decoded.pts = times_.next(frame);
        return true;
    }
}

// Passes the next packet or the end of the file to the decoder; false if the end was passed before.
bool FrameDecoder::feed() {
    if (sentEnd_) return false;
    if (!packets_.read()) {
        sentEnd_ = true;
        avcodec_send_packet(decoder_.get(), nullptr);
        if (twinDecoder_) avcodec_send_packet(twinDecoder_.get(), nullptr);
        return true;
    }
    const AVPacket& packet = packets_.packet();
    if (packet.data == nullptr && packet.size == 0) return true;
    const bool isOfTwin = twin_ != nullptr && packet.stream_index == twin_->index;
    if (!packets_.isOfPictures() && !isOfTwin) {
        packets_.keep();
        return true;
    }
    const bool isCorrupt = (packet.flags & AV_PKT_FLAG_CORRUPT) != 0;
    if (isCorrupt && packet.pts != AV_NOPTS_VALUE) corruptPts_.insert(packet.pts);
    AVCodecContext* const decoder = (isOfTwin ? twinDecoder_ : decoder_).get();
    const int sent = avcodec_send_packet(decoder, &packet);
    if (sent == AVERROR(ENOMEM)) checkMemory(nullptr);
    if (sent < 0 && sent != AVERROR(EAGAIN)) ++counts_.corrupt;
    return true;
}

bool FrameDecoder::isDamaged(const AVFrame& frame) {
    return (frame.flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame.decode_error_flags != 0 ||
           corruptPts_.erase(frame.pts) != 0;
}

} // namespace altiro3D
