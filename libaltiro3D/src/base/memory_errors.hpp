#pragma once

#include "altiro3D/error.hpp"

#include <new>
#include <opencv2/core.hpp>
#include <string>

namespace altiro3D {

/// Does some work; if memory runs out in it, which the language and OpenCV tell in their own ways,
/// throws Error OutOfMemory.
///
/// @param subject what is to blame
/// @param problem "does not fit into memory, expected ..."
/// @param work called once @return what it returns
template <class Work>
auto orOutOfMemory(const std::string& subject, const std::string& problem, const Work& work) {
    try {
        return work();
    } catch (const std::bad_alloc&) {
        throw Error(ErrorCode::OutOfMemory, subject, problem);
    } catch (const cv::Exception& exception) {
        if (exception.code != cv::Error::StsNoMem) throw;
        throw Error(ErrorCode::OutOfMemory, subject, problem);
    }
}

} // namespace altiro3D
