// Natives of a camera, frame by frame, until Ctrl-C:
//
//     film_natives visual.json /dev/video0 natives.mkv
#include <altiro3D/altiro3D.hpp>

#include <csignal>
#include <cstdio>

namespace {

volatile std::sig_atomic_t isStopped = 0;

void stop(int /*signal*/) {
    isStopped = 1;
}

void film(const char* calibration, const char* camera, const char* file) {
    altiro3D::NativeOptions options;
    options.showLive(); // its comment says what is off, and what the rest costs per frame
    const altiro3D::NativeMaker maker(altiro3D::readDisplay(calibration), options);

    // The network runs when the picture has changed; between, depth follows the motion.
    const auto network = altiro3D::estimatedDepth();
    altiro3D::VideoDepth depth(
        [&](const cv::Mat& picture, cv::Mat& raw) {
            cv::Mat photo;
            network->readFrame(picture, photo, raw);
        },
        network->kind());

    altiro3D::VideoReader reader(camera);
    altiro3D::VideoWriterOptions writing;
    writing.size = maker.panelSize();
    writing.native = true;
    writing.timeBase = reader.facts().timeBase;
    altiro3D::VideoWriter writer(file, writing);

    altiro3D::VideoFrame frame;
    altiro3D::Scene scene;
    cv::Mat native;
    while (isStopped == 0 && reader.read(frame)) {
        scene.photo = frame.picture;
        depth.next(scene.photo, scene.depth);
        maker.makeNative(scene, native);
        frame.picture = native; // or show it on the display, full screen and unscaled
        writer.write(frame);
    }
    writer.finish();
}

} // namespace

int main(int argc, char** argv) try {
    if (argc != 4) {
        std::fprintf(stderr, "usage: %s CALIBRATION CAMERA VIDEO\n", argv[0]);
        return 2;
    }
    std::signal(SIGINT, stop);
    film(argv[1], argv[2], argv[3]);
} catch (const altiro3D::Error& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
}
