// Writes first inputs for the fuzz targets: a directory for each.
//
//   altiro3D_fuzz_seeds DIR

#include "altiro3D/file_io.hpp"
#include "altiro3D/native_lut.hpp"
#include "altiro3D/splats.hpp"
#include "altiro3D/video_depth.hpp"
#include "altiro3D/video_io.hpp"
#include "support/displays.hpp"
#include "support/onnx.hpp"
#include "support/photo_files.hpp"
#include "video_samples.hpp"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <exception>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

using namespace altiro3D;
using namespace altiro3D::fuzz;

namespace fs = std::filesystem;

namespace {

class Seeds {
  public:
    Seeds(const fs::path& root, const std::string& target) : directory_(root / target) {
        fs::create_directories(directory_);
    }
    void add(const std::string& contents) {
        std::ofstream stream(directory_ / ("seed" + std::to_string(++count_)), std::ios::binary);
        stream << contents;
    }

  private:
    fs::path directory_;
    int count_ = 0;
};

using test::bigEndian;
using test::encoded;
using test::littleEndian;
using test::pngChunk;

// --- EXIF --------------------------------------------------------------------------------------

// A little-endian directory with an orientation, and one behind it with another number.
std::string exifBlob() {
    const auto entry = [](unsigned tag, unsigned type, std::size_t value) {
        return littleEndian(tag, 2) + littleEndian(type, 2) + littleEndian(1, 4) +
               littleEndian(value, 4);
    };
    const std::size_t second = 8 + 2 + 2 * 12 + 4;
    return std::string("II*\0", 4) + littleEndian(8, 4) + littleEndian(2, 2) + entry(0x0112, 3, 6) +
           entry(0x8769, 4, second) + littleEndian(0, 4) + littleEndian(1, 2) +
           entry(0xa405, 3, 28) + littleEndian(0, 4);
}

void addExif(const fs::path& root) {
    Seeds seeds(root, "exif");
    for (char kind = 0; kind < 5; ++kind) {
        seeds.add(kind + exifBlob());
        seeds.add(kind + std::string("Exif\0\0", 6) + exifBlob());
    }
    seeds.add('\1' + std::string("Raw profile type exif\0\nexif\n  4\n4949", 36));
    seeds.add('\2' + std::string("Raw profile type APP1\0\0x", 24));
}

// --- pictures ----------------------------------------------------------------------------------

// Behind the first `at` bytes.
std::string inserted(std::string bytes, std::size_t at, const std::string& part) {
    return bytes.insert(std::min(at, bytes.size()), part);
}

// Samples, a page that is a thumbnail, and one that is not.
std::string tiffFile(unsigned photometric, unsigned bits, unsigned planes) {
    const std::string samples(192, 'T');
    const unsigned channels = photometric == 5 ? 4 : photometric == 2 || photometric > 5 ? 3 : 1;
    const auto page = [&](unsigned subfile) {
        const std::pair<unsigned, std::size_t> tags[] = {{0xfe, subfile},
                                                         {0x100, 3},
                                                         {0x101, 2},
                                                         {0x102, bits},
                                                         {0x103, 1},
                                                         {0x106, photometric},
                                                         {0x111, 8},
                                                         {0x112, 6},
                                                         {0x115, channels},
                                                         {0x116, 2},
                                                         {0x117, samples.size()},
                                                         {0x11c, planes},
                                                         {0x153, bits == 32 ? 3U : 1U}};
        std::string directory = littleEndian(std::size(tags), 2);
        for (const auto& [tag, value] : tags)
            directory += littleEndian(tag, 2) + littleEndian(3, 2) + littleEndian(1, 4) +
                         littleEndian(value, 4);
        return directory;
    };
    const std::size_t first = 8 + samples.size();
    return std::string("II*\0", 4) + littleEndian(first, 4) + samples + page(1) +
           littleEndian(first + page(1).size() + 4, 4) + page(0) + littleEndian(0, 4);
}

std::vector<std::string> samplePictures() {
    std::vector<std::string> all;
    for (const int type : {CV_8UC1, CV_8UC3, CV_8UC4, CV_16UC1, CV_16UC3, CV_16UC4}) {
        cv::Mat picture(6, 10, type);
        cv::randu(picture, 0, 255);
        for (const char* extension : {".png", ".tiff", ".bmp", ".webp", ".jp2", ".pnm", ".jpg"}) {
            const bool is8Bit = picture.depth() == CV_8U;
            const std::string name = extension;
            if (!is8Bit && name != ".png" && name != ".tiff" && name != ".jp2" && name != ".pnm")
                continue;
            if (picture.channels() == 4 && (name == ".pnm" || name == ".jpg")) continue;
            // JPEG 2000 needs room for its levels
            all.push_back(encoded(name, name == ".jp2" ? cv::repeat(picture, 6, 4) : picture));
        }
    }
    cv::Mat numbers(6, 10, CV_32FC1);
    cv::randu(numbers, 0, 2);
    cv::Mat colours(6, 10, CV_32FC3);
    cv::randu(colours, 0, 2);
    all.push_back(encoded(".tiff", numbers));
    all.push_back(encoded(".tiff", colours));
    all.push_back(encoded(".hdr", colours));
    all.push_back(encoded(".exr", colours));
    all.push_back("P1\n# bits\n3 2\n1 0 1\n0 1 0\n");
    all.push_back("P2\n3 2\n1000\n1 0 1000\n0 999 0\n");
    all.push_back("Pf\n2 1\n-1.0\n" + std::string(8, '\1'));
    cv::Mat photo(24, 32, CV_8UC3);
    cv::randu(photo, 0, 255);
    const std::string jpeg = encoded(".jpg", photo);
    const std::string exif = std::string("Exif\0\0", 6) + exifBlob();
    all.push_back(inserted(jpeg, 2, "\xff\xe1" + bigEndian(exif.size() + 2, 2) + exif));
    all.push_back(inserted(
        jpeg, 2, "\xff\xee" + bigEndian(14, 2) + "Adobe" + std::string("\0d\0\0\0\0\1", 7)));
    all.push_back(inserted(jpeg, 2,
                           "\xff\xe2" + bigEndian(20, 2) +
                               std::string("MPF\0II*\0\10\0\0\0\0\0\0\0\0\0", 18)));
    all.push_back(encoded(".jpg", photo, {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
    all.push_back(encoded(".jpg", photo, {cv::IMWRITE_JPEG_RST_INTERVAL, 1}));
    const std::string png = encoded(".png", photo);
    constexpr std::size_t kBehindHeader = 33;
    for (const std::string& chunk :
         {pngChunk("eXIf", exifBlob()), pngChunk("tRNS", std::string("\0\1\0\2\0\3", 6)),
          pngChunk("acTL", bigEndian(2, 4) + bigEndian(0, 4)),
          pngChunk("tEXt", std::string("Raw profile type exif\0\nexif\n 4\n4949", 35))}) {
        all.push_back(inserted(png, kBehindHeader, chunk));
    }
    const auto riff = [](const std::string& chunks) {
        return "RIFF" + littleEndian(chunks.size() + 4, 4) + "WEBP" + chunks;
    };
    all.push_back(riff("VP8X" + littleEndian(10, 4) + std::string("\x1a\0\0\0\7\0\0\7\0\0", 10) +
                       "EXIF" + littleEndian(exif.size(), 4) + exif + "ANMF" + littleEndian(0, 4)));
    cv::Mat frame(8, 8, CV_8UC4);
    cv::randu(frame, 0, 255);
    for (const int quality : {50, 101}) { // 101: without loss
        const std::string still = encoded(".webp", frame, {cv::IMWRITE_WEBP_QUALITY, quality});
        const std::string chunks = still.substr(quality == 50 ? 30 : 12);
        all.push_back(riff("VP8X" + littleEndian(10, 4) +
                           std::string("\x12\0\0\0\7\0\0\7\0\0", 10) + "ANMF" +
                           littleEndian(chunks.size() + 16, 4) +
                           std::string("\0\0\0\0\0\0\7\0\0\7\0\0\1\0\0\0", 16) + chunks));
    }
    for (const unsigned photometric : {0U, 1U, 2U, 3U, 5U, 6U, 8U, 9U, 32845U}) {
        for (const unsigned bits : {1U, 8U, 12U, 16U, 32U}) {
            for (const unsigned planes : {1U, 2U})
                all.push_back(tiffFile(photometric, bits, planes));
        }
    }
    all.push_back(std::string("MM\0+\0\10\0\0\0\0\0\0\0\0\0\x10\0\0\0\0\0\0\0\1\1\0\0\3", 28) +
                  std::string(24, '\0'));
    all.push_back(std::string("v/1\1\2\0\0\0", 8) + std::string("dataWindow\0box2i\0", 17) +
                  littleEndian(16, 4) + littleEndian(0, 8) + littleEndian(3, 4) +
                  littleEndian(2, 4) + '\0');
    all.push_back("<!DOCTYPE html><html></html>");
    all.push_back("<?xml version=\"1.0\"?><svg></svg>");
    all.push_back("#define a_width 16\n");
    all.push_back(std::string("\0\0\0\x18"
                              "ftypheic",
                              12));
    all.push_back(std::string("\x0a\x05\x01\x08", 4) + std::string(128, '\0'));
    all.push_back("GIF89a");
    return all;
}

void addPictures(const fs::path& root) {
    Seeds headers(root, "picture_header");
    Seeds pictures(root, "picture");
    char kind = 0;
    for (const std::string& bytes : samplePictures()) {
        headers.add(kind + bytes);
        headers.add('\3' + bytes);
        for (const int reader : {kind & ~3, (kind & ~3) + 1, (kind & ~3) + 2, (kind & ~3) + 3})
            pictures.add(static_cast<char>(reader) + bytes);
        ++kind;
    }
}

void addHeif(const fs::path& root) {
    Seeds seeds(root, "heif");
    seeds.add(test::appleHeic());
    seeds.add(test::appleHeic(true));
    seeds.add(test::heifFile("avif", {test::av1Colours(1)}));
    seeds.add(test::spatialHeic());
}

void addEmbeddedDepth(const fs::path& root) {
    const auto coded = [](const std::string& extension, int columns, int rows) {
        cv::Mat picture(rows, columns, CV_8UC1);
        cv::randu(picture, 0, 255);
        return encoded(extension, picture);
    };
    const std::string photo = coded(".jpg", 16, 12);
    const std::string depth = coded(".jpg", 8, 6);
    Seeds seeds(root, "embedded_depth");
    seeds.add(test::dynamicDepthPhoto(photo, {{"Depth", depth, ""}, {"Original", depth, ""}}));
    seeds.add(test::dynamicDepthPhoto(photo, {{"", depth, "android/depthmap"}}, "RangeLinear", 1, 2,
                                      true));
    seeds.add(test::gDepthPhoto(photo, coded(".png", 8, 6), "RangeLinear", 1, 2, depth));
    seeds.add(test::appleJpeg(photo, {depth, test::appleAuxiliary(depth, "disparity")}));
    seeds.add(test::mpoFile(photo, photo));
    const std::string part =
        test::xmpOf("xmlns:GPano='http://ns.google.com/photos/1.0/panorama/' "
                    "GPano:ProjectionType='equirectangular' GPano:CroppedAreaImageWidthPixels='64' "
                    "GPano:FullPanoWidthPixels='128' GPano:CroppedAreaImageHeightPixels='8' "
                    "GPano:FullPanoHeightPixels='64'");
    const std::string right = test::xmpOf("xmlns:GImage='http://ns.google.com/photos/1.0/image/' "
                                          "GImage:Data='" +
                                          test::toBase64(photo) + "'");
    seeds.add(test::withSegments(photo, test::xmpSegment(part) + test::moreXmpSegments(right)));
    seeds.add(test::withSegments(photo, test::jpsSegment(2, 4)));
    seeds.add(test::withSegments(photo, test::jpsSegment(3, 1, 2)));
    seeds.add(inserted(coded(".png", 16, 12), 33, pngChunk("sTER", "\1")));
}

// The first byte chooses between a whole PNG and a bare profile.
void addColour(const fs::path& root) {
    const std::string png =
        std::string("\x89PNG\r\n\x1a\n", 8) +
        pngChunk("IHDR", bigEndian(2, 4) + bigEndian(2, 4) + std::string("\x08\2\0\0\0", 5));
    Seeds seeds(root, "colour");
    seeds.add('\0' + png + pngChunk("cICP", std::string("\x09\x10\0\1", 4)));
    seeds.add('\0' + png + pngChunk("cICP", std::string("\x0c\x0d\0\1", 4)));
    std::string primaries = bigEndian(31270, 4) + bigEndian(32900, 4);
    for (const std::size_t value : {64000U, 33000U, 30000U, 60000U, 15000U, 6000U})
        primaries += bigEndian(value, 4);
    seeds.add('\0' + png + pngChunk("gAMA", bigEndian(100000, 4)) + pngChunk("cHRM", primaries));
    const std::string withoutTags = bigEndian(132, 4) + std::string(8, '\0') + "mntrRGB XYZ " +
                                    std::string(12, '\0') + "acsp" + std::string(88, '\0') +
                                    bigEndian(0, 4);
    seeds.add('\1' + withoutTags);
    const std::string chunk = "ICCP" + littleEndian(withoutTags.size()) + withoutTags;
    seeds.add('\0' + ("RIFF" + littleEndian(chunk.size() + 4)) + "WEBP" + chunk);
    std::string corners(32, '\0'); // of P3
    const float p3[] = {0.68F, 0.32F, 0.265F, 0.69F, 0.15F, 0.06F, 0.3127F, 0.329F};
    std::memcpy(corners.data(), p3, sizeof p3);
    seeds.add('\0' + ("\x76\x2f\x31\x01" + std::string("\2\0\0\0", 4)) +
              std::string("chromaticities\0chromaticities\0\x20\0\0\0", 34) + corners);
    seeds.add('\0' + std::string("#?RADIANCE\nPRIMARIES=.68 .32 .265 .69 .15 .06 .3127 .329\n\n"));
}

// --- everything else ---------------------------------------------------------------------------

void addMaps(const fs::path& root) {
    const fs::path file = root / "a.map";
    NativeLut(test::stripePanel(17, 16), {2, 2, {3, 4}, 4}).save(file);
    const std::string map = contentsOf(file);
    fs::remove(file);
    Seeds seeds(root, "native_lut");
    seeds.add(map);
    seeds.add(map.substr(0, 200));
    seeds.add(map + "more");
}

void addNetworks(const fs::path& root) {
    using namespace test::onnx;
    const std::string weights = bytes(8, "w") + number(14, 1) +
                                bytes(13, bytes(1, "location") + bytes(2, "weights.bin")) +
                                std::string("\x25\0\0\0\0", 5);
    const std::string conv =
        node("Conv", {"in"}, {"out"}, bytes(5, bytes(1, "value") + bytes(5, weights)));
    const std::string graph = conv + bytes(5, weights) +
                              bytes(11, valueInfo("in", {1, 3, 32, 32})) + bytes(11, bytes(1, "w"));
    Seeds seeds(root, "onnx_facts");
    seeds.add(model(graph));
    seeds.add(number(1, 7) + std::string("\x39\0\0\0\0\0\0\0\0", 9) + bytes(7, ""));
    seeds.add("\x0b");
}

void addRuns(const fs::path& root) {
    const Leftovers leftovers = beginRun(root / "a.mkv");
    discardUnfinishedVideo(root / "a.mkv");
    Seeds seeds(root, "video_run");
    seeds.add(leftovers.run);
    std::string other = leftovers.run;
    other.replace(other.find("layered"), 7, "fast");
    seeds.add(other);
}

void addStates(const fs::path& root) {
    Seeds seeds(root, "depth_state");
    VideoDepth depth(
        [](const cv::Mat& picture, cv::Mat& raw) { cv::extractChannel(picture, raw, 1); },
        DepthKind::NearWhite);
    cv::Mat picture(12, 16, CV_8UC3);
    cv::randu(picture, 0, 255);
    cv::Mat map;
    for (int i = 0; i < 3; ++i) {
        const std::string state = depth.state().bytes;
        seeds.add(state.substr(0, state.size() - sizeof(std::uint64_t)));
        depth.next(picture, map);
        picture += cv::Scalar::all(5);
    }
}

void addVideos(const fs::path& root) {
    Seeds seeds(root, "video");
    const std::pair<const char*, VideoCodec> kinds[] = {{"a.mkv", VideoCodec::Ffv1},
                                                        {"a.mp4", VideoCodec::H264},
                                                        {"a.mov", VideoCodec::ProRes},
                                                        {"b.mkv", VideoCodec::H264Rgb}};
    for (const auto& [name, codec] : kinds) {
        VideoWriterOptions options = videoOptions();
        options.codec = codec;
        options.tags = {{"title", "seed"}};
        VideoWriter writer(root / name, options);
        for (int i = 0; i < 4; ++i)
            writer.write({samplePicture(i), 2 * i, 2});
        writer.finish();
        const std::string video = contentsOf(root / name);
        fs::remove(root / name);
        for (char flags = 0; flags < 16; ++flags)
            seeds.add(flags + video);
        seeds.add('\0' + video.substr(0, video.size() * 2 / 3));
    }
    // Raw pictures in a text container: cheap to change.
    const std::string frame(16 * 16 * 3 / 2, '\x55');
    seeds.add('\0' + std::string("YUV4MPEG2 W16 H16 F25:1 Ip A1:1 C420\n") + "FRAME\n" + frame +
              "FRAME\n" + frame);
    seeds.add(std::string(1, '\0') + "just text\n");
}

void addNames(const fs::path& root) {
    Seeds quilts(root, "quilt");
    quilts.add("photo_qs8x6a0.75.png\n6x8\n560x420\n\7\15\16");
    quilts.add("photo.png\n5x9\n20x30\n\3");
    quilts.add("_qs1x1a99.png\n8x6\n420x560\n\3");
    quilts.add("a_qs5x9a1.7\n9x5\n0x0\n\4");
    Seeds views(root, "view_names");
    views.add("view9.png\nview10.png\nView010.PNG\nview_1.jpg\n.hidden.png\nnotes.txt\nb.exr");
    views.add("1.png\n01.png\n001.png\na1b2.png\na1b02.png\n");
}

void addSplats(const fs::path& root) {
    Seeds seeds(root, "splats");
    SplatScene scene;
    scene.degree = 1;
    for (int i = 0; i < 3; ++i) {
        const auto place = static_cast<float>(i);
        scene.splats.push_back(
            {{place, 1, 2 + place}, {0.1F, 0.2F, 0.3F}, {1, 0, 0, 0}, {1, 0, 0}, 0.5F});
        scene.harmonics.insert(scene.harmonics.end(), 9, 0.1F);
    }
    SplatCamera camera;
    camera.size = {40, 30};
    camera.intrinsics = {30, 30, 19.5, 14.5};
    for (const char* const name : {"seed.spz", "seed.ply"}) {
        writeSplats(root / name, scene);
        seeds.add(readFile(root / name, 1 << 20));
        fs::remove(root / name);
        scene.camera = camera; // of the .ply
    }
    seeds.add(
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty list uchar int v\n"
        "property float opacity\nend_header\n1 2 3 4 0.5\n");
    seeds.add(std::string(64, '\x40'));
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: altiro3D_fuzz_seeds DIR\n");
        return 2;
    }
    try {
        const fs::path root = argv[1];
        fs::create_directories(root);
        addExif(root);
        addPictures(root);
        addHeif(root);
        addEmbeddedDepth(root);
        addColour(root);
        addMaps(root);
        addNetworks(root);
        addRuns(root);
        addStates(root);
        addVideos(root);
        addNames(root);
        addSplats(root);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "altiro3D_fuzz_seeds: error: %s\n", error.what());
        return 1;
    }
    return 0;
}
