#include "media/deinterlacer.hpp"

#include "altiro3D/error.hpp"

#include <dlfcn.h>
#include <utility>

extern "C" {
#include <libavfilter/buffersink.h>
#include <libavfilter/buffersrc.h>
}

namespace altiro3D {

namespace {

constexpr const char* kFilters = "libavfilter.so." AV_STRINGIFY(LIBAVFILTER_VERSION_MAJOR);

// The functions of libavfilter. Loaded with the first interlaced frame, not linked: its libraries
// would take a fifth of every program's start-up time.
class Filters {
  public:
    static const Filters& get() {
        static const Filters filters;
        return filters;
    }

    bool areThere = true;
    decltype(&avfilter_graph_alloc) allocGraph = nullptr;
    decltype(&avfilter_graph_free) freeGraph = nullptr;
    decltype(&avfilter_graph_parse_ptr) parse = nullptr;
    decltype(&avfilter_graph_config) config = nullptr;
    decltype(&avfilter_graph_get_filter) filterOf = nullptr;
    decltype(&av_buffersrc_add_frame) addFrame = nullptr;
    decltype(&av_buffersink_get_frame) getFrame = nullptr;
    decltype(&av_buffersink_get_time_base) timeBaseOf = nullptr;

  private:
    Filters() : library_(dlopen(kFilters, RTLD_NOW)) {
        load(allocGraph, "avfilter_graph_alloc");
        load(freeGraph, "avfilter_graph_free");
        load(parse, "avfilter_graph_parse_ptr");
        load(config, "avfilter_graph_config");
        load(filterOf, "avfilter_graph_get_filter");
        load(addFrame, "av_buffersrc_add_frame");
        load(getFrame, "av_buffersink_get_frame");
        load(timeBaseOf, "av_buffersink_get_time_base");
    }

    template <class Function>
    void load(Function& function, const char* name) {
        if (library_ != nullptr) function = reinterpret_cast<Function>(dlsym(library_, name));
        areThere = areThere && function != nullptr;
    }

    void* library_;
};

bool areAlike(const AVFrame& a, const AVFrame& b) {
    return a.width == b.width && a.height == b.height && a.format == b.format;
}

// Another reference to the same picture.
void copyReference(const AVFrame& from, AVFrame& to) {
    av_frame_unref(&to);
    if (av_frame_ref(&to, &from) < 0) checkMemory(nullptr);
}

} // namespace

void FreeGraph::operator()(AVFilterGraph* graph) const {
    // NOLINTNEXTLINE(clang-analyzer-core.CallAndMessage): a graph exists only with the functions
    Filters::get().freeGraph(&graph);
}

bool isInterlaced(const AVFrame& frame) {
#if LIBAVUTIL_VERSION_INT >= AV_VERSION_INT(58, 7, 100)
    return (frame.flags & AV_FRAME_FLAG_INTERLACED) != 0;
#else
    return frame.interlaced_frame != 0;
#endif
}

Deinterlacer::Deinterlacer(AVRational unit, int threads, std::string subject)
    : unit_(unit), threads_(threads), subject_(std::move(subject)) {}

void Deinterlacer::restart() {
    graph_.reset();
    hasLast_ = false;
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
    if (filters.addFrame(source_, frame.get()) < 0) checkMemory(nullptr);
    for (;;) {
        DecodedFrame made;
        if (filters.getFrame(sink_, made.frame.get()) < 0) return; // at the end, or too few
        made.pts = av_rescale_q(made.frame->pts, filters.timeBaseOf(sink_), unit_);
        if (!std::exchange(skips_, false)) ready_.push_back(std::move(made));
    }
}

void Deinterlacer::give(DecodedFrame& decoded) {
    const AVFrame& frame = *decoded.frame;
    const bool isAlike = hasLast_ && areAlike(*last_.frame, frame);
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
            push(&last_);
        }
        push(&decoded);
    }
    copyReference(frame, *last_.frame);
    last_.pts = decoded.pts;
    hasLast_ = true;
}

void Deinterlacer::end() {
    if (graph_) push(nullptr);
    graph_.reset();
    hasLast_ = false;
}

bool Deinterlacer::take(DecodedFrame& decoded) {
    if (ready_.empty()) return false;
    std::swap(decoded, ready_.front());
    ready_.pop_front();
    return true;
}

} // namespace altiro3D
