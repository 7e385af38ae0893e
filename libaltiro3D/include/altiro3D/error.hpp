#pragma once

#include "altiro3D/export.hpp"

#include <stdexcept>
#include <string>

namespace altiro3D {

/// What kind of thing went wrong, for programs; the sentence in `what()` is for people.
enum class ErrorCode {
    InvalidArgument, ///< An argument is out of its range or of the wrong size or type.
    NotFound,        ///< A file or directory does not exist.
    ReadFailed,      ///< A file exists but cannot be read.
    WriteFailed,     ///< An output cannot be written (permission, full disk, ...).
    BadFormat,       ///< The contents of a file are not what they should be.
    Unsupported,     ///< A known format or feature without a reader here.
    TooLarge,        ///< A size beyond the limit; found before memory is taken.
    Mismatch,        ///< Two inputs do not belong together (map and quilt, photo and depth).
    OutOfMemory,     ///< Memory for a valid request is not to be had.
    NetworkFailed    ///< A depth network cannot be loaded or run.
};

/// The one exception of the library.
///
/// Its text is one line of the form `<file or argument>: <what is wrong>, expected <what>`.
class ALTIRO3D_EXPORT Error : public std::runtime_error {
  public:
    /// @param code what kind of failure
    /// @param subject the file or argument that is to blame, as the user wrote it
    /// @param problem what is wrong with it and what was expected instead
    Error(ErrorCode code, const std::string& subject, const std::string& problem);

    /// What kind of failure this is. @return as given to the constructor
    ErrorCode code() const noexcept { return code_; }

  private:
    ErrorCode code_;
};

} // namespace altiro3D
