#include "image/opencv_codecs.hpp"

#include <opencv2/imgcodecs.hpp>

#ifdef ALTIRO3D_HAVE_OPENEXR
#include "altiro3D/image_io.hpp"
#include "image/image_header.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <cstring>
#include <stdexcept>
#endif

namespace {

cv::Mat decode(const cv::Mat& encoded, int flags) {
    return cv::imdecode(encoded, flags);
}

bool encode(const std::string& extension, const cv::Mat& image, std::vector<unsigned char>& bytes) {
    return cv::imencode(extension, image, bytes);
}

#ifdef ALTIRO3D_HAVE_OPENEXR

using altiro3D::ExrChannel;

class MemoryStream : public Imf::IStream {
  public:
    explicit MemoryStream(std::string_view bytes) : Imf::IStream("memory"), bytes_(bytes) {}
    bool read(char to[], int count) override {
        const auto size = static_cast<std::size_t>(count);
        if (count < 0 || at_ > bytes_.size() || bytes_.size() - at_ < size)
            throw std::runtime_error("the file is cut off");
        std::memcpy(to, bytes_.data() + at_, size);
        at_ += size;
        return at_ < bytes_.size();
    }
    std::uint64_t tellg() override { return at_; }
    void seekg(std::uint64_t at) override { at_ = at; }

  private:
    std::string_view bytes_;
    std::uint64_t at_ = 0;
};

// OpenCV allocates what a file states.
void limitSizes() {
    Imf::Header::setMaxImageSize(altiro3D::kMaxImageSide, altiro3D::kMaxImageSide);
    Imf::Header::setMaxTileSize(4096, 4096);
}

std::vector<ExrChannel> exrChannels(std::string_view bytes) {
    limitSizes();
    MemoryStream stream(bytes);
    const Imf::MultiPartInputFile file(stream, 0);
    std::vector<ExrChannel> channels;
    for (int part = 0; part < file.parts(); ++part) {
        const Imf::Header& header = file.header(part);
        if (header.hasType() && Imf::isDeepData(header.type())) continue;
        const std::string before =
            file.parts() > 1 && header.hasName() ? header.name() + "." : std::string();
        const Imf::ChannelList& list = header.channels();
        for (auto channel = list.begin(); channel != list.end(); ++channel) {
            if (channel.channel().xSampling != 1 || channel.channel().ySampling != 1) continue;
            const std::string name = channel.name();
            channels.push_back({part, name, name.find(before) == 0 ? name : before + name});
        }
    }
    return channels;
}

cv::Rect rectOf(const Imath::Box2i& box) {
    const auto span = [](int low, int high) {
        const std::int64_t size = std::int64_t{high} - low + 1;
        if (size < 1 || size > altiro3D::kMaxImageSide) throw std::runtime_error("bad window");
        return static_cast<int>(size);
    };
    return {box.min.x, box.min.y, span(box.min.x, box.max.x), span(box.min.y, box.max.y)};
}

cv::Mat readExr(std::string_view bytes, const std::vector<ExrChannel>& channels) {
    limitSizes();
    MemoryStream stream(bytes);
    Imf::MultiPartInputFile file(stream, 0);
    Imf::InputPart part(file, channels.at(0).part);
    const Imath::Box2i& window = part.header().dataWindow();
    const cv::Rect data = rectOf(window);
    const cv::Rect shown = rectOf(part.header().displayWindow());
    for (const cv::Rect& each : {data, shown}) {
        if (static_cast<double>(each.width) * each.height > altiro3D::kMaxImagePixels)
            throw std::runtime_error("too many px");
    }
    const int count = static_cast<int>(channels.size());
    cv::Mat picture(data.size(), CV_32FC(count), cv::Scalar::all(0));
    Imf::FrameBuffer buffer;
    for (int i = 0; i < count; ++i) {
        buffer.insert(channels[static_cast<std::size_t>(i)].name,
                      Imf::Slice::Make(Imf::FLOAT, picture.ptr<float>() + i, window,
                                       picture.elemSize(), picture.step[0]));
    }
    part.setFrameBuffer(buffer);
    part.readPixels(window.min.y, window.max.y);
    if (data == shown) return picture;
    cv::Mat whole(shown.size(), picture.type(), cv::Scalar::all(0));
    const cv::Rect both = data & shown;
    if (!both.empty()) picture(both - data.tl()).copyTo(whole(both - shown.tl()));
    return whole;
}

#else

constexpr decltype(altiro3D::OpenCvCodecs::exrChannels) exrChannels = nullptr;
constexpr decltype(altiro3D::OpenCvCodecs::readExr) readExr = nullptr;

#endif

} // namespace

const altiro3D::OpenCvCodecs kAltiro3dOpenCvCodecs = {decode, encode, exrChannels, readExr};

// For builds that link the codecs; opencv_codecs_loaded.cpp loads them at run time.
const altiro3D::OpenCvCodecs& altiro3D::openCvCodecs() {
    return kAltiro3dOpenCvCodecs;
}
