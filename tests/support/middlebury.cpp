#include "support/middlebury.hpp"

#include "support/files.hpp"

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>

namespace altiro3D::test {

namespace fs = std::filesystem;

// Columns: scene, year, left, right, disparity of the left, of the right, scale, ...
std::vector<MiddleburyFiles> listMiddlebury(const fs::path& folder) {
    std::vector<MiddleburyFiles> scenes;
    std::ifstream list(folder / "scenes.csv");
    std::string line;
    std::getline(list, line);
    while (std::getline(list, line)) {
        std::vector<std::string> fields;
        std::istringstream cells(line);
        for (std::string field; std::getline(cells, field, ',');)
            fields.push_back(field);
        if (fields.size() < 7) continue;
        const fs::path scene = folder / fields[0];
        scenes.push_back({fields[0], scene / fields[2], scene / fields[3], scene / fields[4],
                          std::stod(fields[6])});
    }
    return scenes;
}

StereoScene middleburyScene(const std::string& name) {
    for (const MiddleburyFiles& files : listMiddlebury(dataPath("middlebury"))) {
        if (files.name != name) continue;
        const cv::Mat photo = cv::imread(files.left.string());
        const cv::Mat truth = cv::imread(files.right.string());
        cv::Mat disparity = cv::imread(files.disparity.string(), cv::IMREAD_UNCHANGED);
        if (photo.empty() || truth.size() != photo.size() || disparity.size() != photo.size() ||
            disparity.channels() != 1)
            break;
        disparity.convertTo(disparity, CV_32F);
        return makeStereoScene(files.name, photo, disparity, files.scale, truth);
    }
    throw std::runtime_error("the Middlebury pair " + name + " is missing or unreadable");
}

} // namespace altiro3D::test
