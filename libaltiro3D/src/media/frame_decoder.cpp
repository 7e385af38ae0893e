#include "media/frame_decoder.hpp"

namespace altiro3D {

FrameDecoder::FrameDecoder(CodecPtr decoder, VideoPackets& packets, FrameTimes times,
                           std::optional<Deinterlacer> deinterlacer, VideoReadCounts& counts)
    : decoder_(std::move(decoder)), packets_(packets), times_(times),
      deinterlacer_(std::move(deinterlacer)), counts_(counts) {}

void FrameDecoder::restart() {
    avcodec_flush_buffers(decoder_.get());
    corruptPts_.clear();
    sentEnd_ = false;
    times_.restart();
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
        const int result = avcodec_receive_frame(decoder_.get(), &frame);
        if (result == AVERROR_EOF) return false;
        if (result == AVERROR(EAGAIN)) {
            if (!feed()) return false;
            continue;
        }
        if (result == AVERROR(ENOMEM)) checkMemory(nullptr);
        if (result < 0 || isDamaged(frame)) {
            ++counts_.corrupt;
            continue;
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
        return true;
    }
    const AVPacket& packet = packets_.packet();
    if (packet.data == nullptr && packet.size == 0) return true;
    if (!packets_.isOfPictures()) {
        packets_.keep();
        return true;
    }
    const bool isCorrupt = (packet.flags & AV_PKT_FLAG_CORRUPT) != 0;
    if (isCorrupt && packet.pts != AV_NOPTS_VALUE) corruptPts_.insert(packet.pts);
    const int sent = avcodec_send_packet(decoder_.get(), &packet);
    if (sent == AVERROR(ENOMEM)) checkMemory(nullptr);
    if (sent < 0 && sent != AVERROR(EAGAIN)) ++counts_.corrupt;
    return true;
}

bool FrameDecoder::isDamaged(const AVFrame& frame) {
    return (frame.flags & AV_FRAME_FLAG_CORRUPT) != 0 || frame.decode_error_flags != 0 ||
           corruptPts_.erase(frame.pts) != 0;
}

} // namespace altiro3D
