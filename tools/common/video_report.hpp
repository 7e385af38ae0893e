#pragma once

#include "altiro3D/video_conversion.hpp"
#include "common/video_job.hpp"

#include <string>

namespace altiro3D::tools {

/// Result of a run.
struct VideoOutcome {
    VideoConversionResult result;
    cv::Size size;        ///< of the pictures
    bool stopped = false; ///< by the user
    bool failed = false;  ///< the error was reported already
    std::string cutOff;   ///< warning that the input is cut off; empty if it is not

    double rate() const;
    /// "done", "stopped" or "truncated"
    const char* state() const;
};

/// Settings, counts and times of a run, for programs.
std::string videoReport(const CommandLine& commandLine, const VideoJob& job,
                        const VideoOutcome& outcome, const Messages& messages);

/// Shows the details of -v and the number of frames that came too fast.
void tellVideoDetails(const VideoJob& job, const VideoOutcome& outcome, Messages& messages);

} // namespace altiro3D::tools
