// Renders the sample scene for the documentation: a photo and its exact depth.
//
//     altiro3D_make_sample OUTDIR [COLUMNS ROWS [SAMPLES]]
//
// writes OUTDIR/sample.jpg and OUTDIR/sample-depth.png (16 bits, white = near).

#include "support/scene.hpp"

#include <cstdlib>
#include <iostream>
#include <opencv2/imgcodecs.hpp>

int main(int argc, char** argv) {
    const int columns = argc > 3 ? std::atoi(argv[2]) : 900;
    const int rows = argc > 3 ? std::atoi(argv[3]) : 1200;
    const int samples = argc > 4 ? std::atoi(argv[4]) : 16;
    if (argc < 2 || argc == 3 || argc > 5 || columns < 1 || columns > 8192 || rows < 1 ||
        rows > 8192 || samples < 1 || samples > 400) {
        std::cerr << "usage: altiro3D_make_sample OUTDIR [COLUMNS ROWS [SAMPLES]]\n";
        return 2;
    }
    const std::string directory = argv[1];
    try {
        const auto picture = altiro3D::test::render(altiro3D::test::sampleScene(),
                                                    cv::Size(columns, rows), 0, samples);
        cv::Mat depth;
        picture.depth.convertTo(depth, CV_16U, 65535);
        const bool written =
            cv::imwrite(directory + "/sample.jpg", picture.photo, {cv::IMWRITE_JPEG_QUALITY, 92}) &&
            cv::imwrite(directory + "/sample-depth.png", depth, {cv::IMWRITE_PNG_COMPRESSION, 9});
        if (written) return 0;
    } catch (const cv::Exception& exception) {
        std::cerr << "altiro3D_make_sample: error: " << exception.err << '\n';
        return 1;
    }
    std::cerr << "altiro3D_make_sample: error: " << directory << ": cannot be written to\n";
    return 1;
}
