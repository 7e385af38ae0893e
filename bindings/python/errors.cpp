#include "bindings.hpp"

#include <atomic>
#include <future>

namespace altiro3D::python {

namespace {

py::handle errorType; // altiro3d.Error, as long as the module lives

void translate(std::exception_ptr thrown) {
    try {
        std::rethrow_exception(std::move(thrown));
    } catch (const Error& error) {
        const py::object exception = errorType(error.what());
        py::setattr(exception, "code", py::cast(error.code()));
        py::setattr(exception, "subject", py::cast(error.subject()));
        PyErr_SetObject(errorType.ptr(), exception.ptr());
    }
}

template <class Progress>
std::function<bool(Progress)> callbackOf(const std::optional<py::function>& goOn) {
    if (!goOn) return {};
    return [kept = keptOf(*goOn)](Progress progress) {
        const Locked locked;
        const py::object answer = (*kept)(progress);
        return answer.is_none() || py::bool_(answer);
    };
}

} // namespace

void Turn::lock() {
    std::optional<Released> released;
    std::unique_lock<std::mutex> locked(mutex_); // ends before the GIL is taken again
    const bool isTaken = user_ != std::thread::id();
    if (user_ == std::this_thread::get_id() || (isTaken && !waits_)) {
        throw Error(ErrorCode::InvalidArgument, name_,
                    "is in use by another call, expected one call at a time");
    }
    if (isTaken && PyGILState_Check() != 0) released.emplace();
    isFree_.wait(locked, [this] { return user_ == std::thread::id(); });
    user_ = std::this_thread::get_id();
}

void Turn::unlock() {
    const std::lock_guard<std::mutex> locked(mutex_);
    user_ = {};
    isFree_.notify_one();
}

VideoProgressFunction progressOf(const std::optional<py::function>& goOn) {
    return callbackOf<const VideoProgress&>(goOn);
}

std::function<bool(double)> quiltProgressOf(const std::optional<py::function>& goOn) {
    return callbackOf<double>(goOn);
}

void runStoppable(const VideoProgressFunction& goOn,
                  const std::function<void(const VideoProgressFunction&)>& work) {
    std::atomic<bool> isInterrupted = false;
    const VideoProgressFunction checked = [&](const VideoProgress& progress) {
        return !isInterrupted && (!goOn || goOn(progress));
    };
    const Released released;
    std::future<void> run = std::async(std::launch::async, [&] { work(checked); });
    while (run.wait_for(std::chrono::milliseconds(50)) != std::future_status::ready) {
        const Locked locked;
        if (PyErr_CheckSignals() == 0) continue;
        const py::error_already_set interrupt;
        isInterrupted = true;
        const Released again;
        run.wait();
        throw py::error_already_set(interrupt);
    }
    run.get();
}

void bindErrors(py::module_& m) {
    const char* const doc = "A failure of the library: one line, `<file or argument>: <what is "
                            "wrong>, expected <what>`.";
    errorType = PyErr_NewExceptionWithDoc("altiro3d.Error", doc, nullptr, nullptr);
    m.add_object("Error", errorType);
    py::register_exception_translator(translate);

    py::enum_<ErrorCode>(m, "ErrorCode", "Kind of failure, for programs: Error.code.")
        .value("InvalidArgument", ErrorCode::InvalidArgument, "an argument is out of its range")
        .value("NotFound", ErrorCode::NotFound, "a file does not exist")
        .value("ReadFailed", ErrorCode::ReadFailed, "a file cannot be read")
        .value("WriteFailed", ErrorCode::WriteFailed, "an output cannot be written")
        .value("BadFormat", ErrorCode::BadFormat, "the contents of a file are malformed")
        .value("Unsupported", ErrorCode::Unsupported, "a known format that is not supported")
        .value("TooLarge", ErrorCode::TooLarge, "a size beyond the limit")
        .value("Mismatch", ErrorCode::Mismatch, "two inputs do not belong together")
        .value("OutOfMemory", ErrorCode::OutOfMemory, "allocation failed")
        .value("NetworkFailed", ErrorCode::NetworkFailed, "a network cannot be loaded or run");
    py::enum_<NoteCode>(m, "NoteCode", "Kind of a remark.")
        .value("CutOff", NoteCode::CutOff, "the file ends too early")
        .value("LeftOut", NoteCode::LeftOut, "a part is not used")
        .value("Converted", NoteCode::Converted, "a part is converted")
        .value("Repaired", NoteCode::Repaired, "damaged parts are skipped or replaced")
        .value("AsItIs", NoteCode::AsItIs, "a property is not corrected")
        .value("Doubtful", NoteCode::Doubtful, "a value is unlikely")
        .value("Chosen", NoteCode::Chosen, "another picture of the file is used")
        .value("Inverted", NoteCode::Inverted, "near and far look exchanged");
    Value<Note>(m, "Note", "A remark on something unusual that does not prevent the work.")
        .field("code", &Note::code, "Its kind.")
        .field("text", &Note::text, "One line.")
        .done()
        .def("__str__", [](const Note& note) { return note.text; });
}

} // namespace altiro3D::python
