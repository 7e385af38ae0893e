// What a user of the library writes first: a photo and its depth become a Native.

#include <altiro3D/altiro3D.hpp>

#include <cstring>
#include <iostream>
#include <opencv2/core.hpp>

int main(int argc, char** argv) {
    if (argc != 2) return 2;
    try {
        const altiro3D::Calibration display = altiro3D::readCalibration(argv[1]);
        altiro3D::QuiltLayout layout = altiro3D::defaultQuilt(display);
        const cv::Mat photo(layout.tileSize, CV_8UC3, cv::Scalar(10, 20, 30));
        const cv::Mat depth(layout.tileSize, CV_32FC1, cv::Scalar(0.5));
        cv::Mat quilt;
        cv::Mat native;
        altiro3D::Depth2Quilt(layout).render({photo, depth}, quilt);
        altiro3D::Quilt2Native(altiro3D::NativeLut(display, layout)).render(quilt, native);
        std::cout << native.cols << " x " << native.rows << " altiro3D " << altiro3D::version()
                  << "\n";
        if (std::strcmp(altiro3D::version(), ALTIRO3D_VERSION) != 0) return 1;
        return native.at<cv::Vec3b>(100, 100) == cv::Vec3b(10, 20, 30) ? 0 : 1;
    } catch (const altiro3D::Error& error) {
        std::cerr << error.what() << "\n";
        return 1;
    }
}
