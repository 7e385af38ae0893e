#pragma once

#include "altiro3D/error.hpp"

#include <new>
#include <opencv2/core.hpp>
#include <string>

namespace altiro3D {

/// Runs `work` and converts a failed allocation, which the language and OpenCV report differently,
/// to Error OutOfMemory.
///
/// @param subject file or argument for the error
/// @param problem "does not fit into memory, expected ..."
/// @param work called once
/// @return the result of `work`
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
