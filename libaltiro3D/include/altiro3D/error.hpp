#pragma once

#include "altiro3D/export.hpp"

#include <cstddef>
#include <stdexcept>
#include <string>
#include <vector>

namespace altiro3D {

/// Kind of failure, for programs; the text of `what()` is for people.
enum class ErrorCode {
    InvalidArgument, ///< An argument is out of its range or of the wrong size or type.
    NotFound,        ///< A file or directory does not exist.
    ReadFailed,      ///< A file exists but cannot be read.
    WriteFailed,     ///< An output cannot be written (permission, full disk, ...).
    BadFormat,       ///< The contents of a file are malformed or out of range.
    Unsupported,     ///< A known format or feature that the library does not support.
    TooLarge,        ///< A size beyond the limit; detected before allocation.
    Mismatch,        ///< Two inputs do not belong together (map and quilt, photo and depth).
    OutOfMemory,     ///< Allocation failed for a valid request.
    NetworkFailed    ///< A depth network fails when it runs, or crashes or hangs in probeNetwork().
};

/// The name of a code, for reports. @param code the code @return for example "NotFound"
[[nodiscard]] ALTIRO3D_EXPORT const char* errorCodeName(ErrorCode code) noexcept;

/// The exception of the library.
///
/// `what()` is one line, mostly `<file or argument>: <what is wrong>, expected <what>`.
class ALTIRO3D_EXPORT Error : public std::runtime_error {
  public:
    /// @param code kind of failure
    /// @param subject the file or argument at fault, as the user wrote it
    /// @param problem what is wrong with it and what is expected
    Error(ErrorCode code, const std::string& subject, const std::string& problem);

    /// Kind of failure. @return as given to the constructor
    [[nodiscard]] ErrorCode code() const noexcept { return code_; }
    /// The file or argument at fault, as what() names it. @return the first part of what()
    [[nodiscard]] std::string subject() const { return {what(), subjectBytes_}; }

  private:
    ErrorCode code_;
    std::size_t subjectBytes_;
};

/// Turns text from a file or a user into one line without terminal escape sequences: control
/// characters become spaces. Error does this itself. @param text the text @return the line
[[nodiscard]] ALTIRO3D_EXPORT std::string withoutControls(std::string text);

/// Kind of a remark, for programs; the text is for people.
enum class NoteCode {
    CutOff,    ///< The file ends too early; the part that exists is used.
    LeftOut,   ///< A part is not used: further pictures, unused columns, a stream.
    Converted, ///< A part is converted to a form that the output can hold.
    Repaired,  ///< Damaged parts are skipped or replaced.
    AsItIs,    ///< A property is not corrected: interlaced pictures, fringe.
    Doubtful,  ///< A value is unlikely, or the file does not say how to read it.
    Chosen,    ///< Another picture of the file is used, as requested.
    Inverted   ///< Near and far of given depth look exchanged (looksInverted()).
};

/// A remark on something unusual that does not prevent the work.
struct Note {
    NoteCode code = NoteCode::Doubtful; ///< Its kind.
    std::string text;                   ///< One line without a full stop.
};

/// Remarks, in the order in which they arose.
using Notes = std::vector<Note>;

} // namespace altiro3D
