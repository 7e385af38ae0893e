#pragma once

/// @file
/// What all bindings share: conversions of small values, values as classes, functions of Python.

#include <altiro3D/depth_source.hpp>
#include <altiro3D/error.hpp>
#include <altiro3D/video_io.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <opencv2/core/types.hpp>
#include <optional>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <string>
#include <thread>
#include <utility>
#include <vector>

/// Converts texts as os.fsdecode() and os.fsencode() do, because names of files need not be UTF-8.
template <>
struct pybind11::detail::string_caster<std::string> {
    PYBIND11_TYPE_CASTER(std::string, const_name("str"));
    bool load(handle source, bool /*convert*/) {
        if (!isinstance<str>(source)) return false;
        const auto utf8 = reinterpret_steal<bytes>(
            PyUnicode_AsEncodedString(source.ptr(), "utf-8", "surrogateescape"));
        if (!utf8) PyErr_Clear();
        if (utf8) value = utf8;
        return !!utf8;
    }
    static handle cast(const std::string& text, return_value_policy /*policy*/, handle /*of*/) {
        return PyUnicode_DecodeUTF8(text.data(), static_cast<Py_ssize_t>(text.size()),
                                    "surrogateescape");
    }
};

namespace altiro3D::python {

namespace py = pybind11;

// One per stage, in the order in which they are called.
void bindErrors(py::module_& m);
void bindImageIo(py::module_& m);
void bindDisplay(py::module_& m);
void bindDepthMap(py::module_& m);
void bindDepthSource(py::module_& m);
void bindViewOptions(py::module_& m);
void bindPlacement(py::module_& m);
void bindViews(py::module_& m);
void bindNative(py::module_& m);
void bindQuilt2Native(py::module_& m);
void bindSplats(py::module_& m);
void bindLensView(py::module_& m);
void bindPrintSheet(py::module_& m);
void bindVideoIo(py::module_& m);
void bindVideoDepth(py::module_& m);
void bindVideoConversion(py::module_& m);

// The rule for threads. Values are copied while the thread has the GIL, because others may change
// them as soon as it is released. Immutable objects are used as they are. All other objects have a
// Turn, which every call takes.

/// Takes the GIL. Python ends a thread that takes it when the interpreter has ended: it unwinds the
/// thread's stack, which would abort the program. The thread rests instead until the process ends.
template <class Take>
void orRest(const Take& take) {
    try {
        take();
    } catch (...) {
        while (true)
            std::this_thread::sleep_for(std::chrono::seconds(1));
    }
}

/// Lets other threads of Python run.
struct Released {
    Released() : state(PyEval_SaveThread()) {}
    Released(const Released&) = delete;
    Released& operator=(const Released&) = delete;
    ~Released() {
        orRest([this] { PyEval_RestoreThread(state); });
    }
    PyThreadState* state; ///< Of this thread.
};

/// Has the GIL, in any thread.
struct Locked {
    Locked() {
        orRest([this] { gil.emplace(); });
    }
    std::optional<py::gil_scoped_acquire> gil; ///< Holds the GIL.
};

/// Runs the library's part of a function, while other threads of Python run.
/// @param work captures values that it reads by copy
template <class Work>
auto unlocked(const Work& work) {
    const Released released;
    return work();
}

/// Lets threads use an object one at a time.
class Turn {
  public:
    /// @param name of the object's class @param waits false: calls fail while another one runs
    explicit Turn(const char* name, bool waits = true) : name_(name), waits_(waits) {}
    /// Waits without the GIL, which the present call may need for a function of Python.
    /// @throws Error InvalidArgument (the object is in use, by this thread or without waiting)
    void lock();
    void unlock();

  private:
    const char* name_;
    bool waits_;
    std::mutex mutex_; // guards the next ones
    std::condition_variable isFree_;
    std::thread::id user_;
};

/// An object of the library that only one thread may use at a time.
template <class T>
struct OneByOne : T {
    /// @param name of the class, waits see Turn @param given arguments of T
    template <class... Arguments>
    OneByOne(const char* name, bool waits, Arguments&&... given)
        : T(std::forward<Arguments>(given)...), turn(name, waits) {}
    mutable Turn turn; ///< Turn of this object.
};

/// Runs the library's part of a method when it is this thread's turn.
template <class T, class Work>
auto unlocked(const OneByOne<T>& object, const Work& work) {
    const Released released;
    const std::lock_guard<Turn> held(object.turn);
    return work();
}

/// A method without arguments that takes the object's turn. @param method of the library
template <class Object, class Method>
auto inTurn(Method method) {
    return [method](Object& self) { return unlocked(self, [&] { return (self.*method)(); }); };
}

/// An object that threads without the GIL may keep and release.
inline std::shared_ptr<py::object> keptOf(py::object object) {
    return {new py::object(std::move(object)), [](const py::object* kept) {
                const Locked locked;
                delete kept;
            }};
}

/// A path as a result.
struct PathResult {
    PathResult(std::filesystem::path given = {}) : path(std::move(given)) {} ///< @param given it
    std::filesystem::path path;                                              ///< The path.
};

/// The argument `notes`: a list that receives remarks, or None.
class Remarks {
  public:
    /// @param list as given
    explicit Remarks(std::optional<py::list> list) : list_(std::move(list)) {}
    /// For the library. @return null without a list
    [[nodiscard]] Notes* notes() { return list_ ? &notes_ : nullptr; }
    /// Appends the remarks to the list; needs the GIL.
    void give() {
        for (const Note& note : notes_)
            list_->append(note);
    }

  private:
    std::optional<py::list> list_;
    Notes notes_;
};

/// Receives the progress of a run from threads of the library. @param goOn a function that returns
/// False to stop, or None, which means the same as True @return for the library
VideoProgressFunction progressOf(const std::optional<py::function>& goOn);

/// The same for the share of a quilt that is made.
std::function<bool(double)> quiltProgressOf(const std::optional<py::function>& goOn);

/// A source for the library to keep. A class of Python stays alive as long as the library uses it.
/// @param source a DepthSource @return the source
std::shared_ptr<DepthSource> sourceOf(const py::object& source);

/// Runs long work in a second thread, so that Ctrl-C stops it. @param goOn called by `work`
/// @param work called with a function to call instead of `goOn` @throws what `work` throws
void runStoppable(const VideoProgressFunction& goOn,
                  const std::function<void(const VideoProgressFunction&)>& work);

/// A structure of the library as a class: properties, keyword arguments, repr(), ==, copies.
template <class T, class... Base>
class Value {
  public:
    /// @param m the module @param name of the class @param doc its docstring
    Value(py::module_& m, const char* name, const char* doc) : class_(m, name, doc), name_(name) {}

    /// A number, text, list or other value that is copied.
    template <class Owner, class Member>
    Value& field(const char* name, Member Owner::*member, const char* doc) {
        return add(name, member, doc, py::return_value_policy::copy);
    }
    /// A structure inside of the structure: `value.part.field = 1` changes `value`.
    template <class Owner, class Member>
    Value& part(const char* name, Member Owner::*member, const char* doc) {
        return add(name, member, doc, py::return_value_policy::reference_internal);
    }

    /// A value that is not a member.
    /// @param get, set functions of the structure; objects of Python
    Value& property(const char* name, py::object (*get)(const T&),
                    void (*set)(T&, const py::object&), const char* doc) {
        class_.def_property(name, get, set, doc);
        fields_->push_back({name, set});
        return *this;
    }

    /// Makes the constructor, which takes all fields by name, and copies.
    Value& constructible() {
        const py::object defaults = py::cast(std::make_unique<T>());
        std::string signature = "__init__(self: altiro3d." + name_ + ", *";
        for (const Field& field : *fields_)
            signature += ", " + field.name + ": " + typeOf(field.name.c_str()) + " = " +
                         defaultOf(defaults.attr(field.name.c_str()));
        signature += ") -> None\n\nAll fields are keyword arguments.";
        py::options options;
        options.disable_function_signatures();
        class_.def(py::init([fields = fields_, name = name_](const py::kwargs& given) {
                       auto value = std::make_unique<T>();
                       for (const auto& [key, entry] : given)
                           setField(*fields, name, *value, key.template cast<std::string>(), entry);
                       return value;
                   }),
                   signature.c_str());
        class_.def("__copy__", [](const T& value) { return T(value); });
        class_.def(
            "__deepcopy__", [](const T& value, const py::dict& /*memo*/) { return T(value); },
            py::arg("memo"));
        return *this;
    }

    /// The class, after all its fields: with repr() and ==. @return to add more to it
    py::class_<T, Base...> done() {
        class_.def("__repr__", [fields = fields_, name = name_](const py::object& self) {
            std::string text = name + "(";
            for (const Field& field : *fields)
                text += (text.back() == '(' ? "" : ", ") + field.name + "=" +
                        textOf(self.attr(field.name.c_str()));
            return text + ")";
        });
        class_.def(
            "__eq__",
            [fields = fields_](const py::object& self, const py::object& other) {
                if (!py::type::of(self).is(py::type::of(other))) return false;
                for (const Field& field : *fields)
                    if (!self.attr(field.name.c_str()).equal(other.attr(field.name.c_str())))
                        return false;
                return true;
            },
            py::arg("other"));
        return class_;
    }

  private:
    struct Field {
        std::string name;
        std::function<void(T& to, const py::object& given)> set;
    };
    using Fields = std::vector<Field>;

    static void setField(const Fields& fields, const std::string& name, T& value,
                         const std::string& key, const py::handle& given) {
        for (const Field& field : fields)
            if (field.name == key)
                return field.set(value, py::reinterpret_borrow<py::object>(given));
        throw py::type_error(key + ": is not a field of " + name);
    }

    // repr(), but enumerators by their names
    static std::string textOf(const py::object& value) {
        const bool isEnumerator = py::hasattr(value, "__members__");
        return isEnumerator ? py::str(value) : py::repr(value);
    }

    // As in a signature: a structure by its name.
    static std::string defaultOf(const py::object& value) {
        const py::object type = py::type::of(value);
        const bool isStructure = type.attr("__module__").cast<std::string>() == "altiro3d" &&
                                 !py::hasattr(type, "__members__");
        return isStructure ? type.attr("__name__").cast<std::string>() + "()" : textOf(value);
    }

    // As the property's docstring states it.
    static std::string typeOf(const char* field) {
        const auto doc =
            py::type::of<T>().attr(field).attr("fget").attr("__doc__").template cast<std::string>();
        const std::size_t begin = doc.find("-> ") + 3;
        return doc.substr(begin, doc.find('\n') - begin);
    }

    template <class Owner, class Member>
    Value& add(const char* name, Member Owner::*member, const char* doc,
               py::return_value_policy policy) {
        const auto get = [member](const T& value) -> const Member& { return value.*member; };
        const auto set = [member, name](T& value, const py::object& given) {
            try {
                value.*member = given.cast<Member>();
            } catch (const py::cast_error&) {
                throw py::type_error(std::string(name) + ": is " +
                                     py::repr(given).cast<std::string>() + ", expected " +
                                     typeOf(name));
            }
        };
        class_.def_property(name, py::cpp_function(get, policy, py::is_method(class_)),
                            py::cpp_function(set, py::is_method(class_)), doc);
        fields_->push_back({name, set});
        return *this;
    }

    py::class_<T, Base...> class_;
    std::string name_;
    std::shared_ptr<Fields> fields_ = std::make_shared<Fields>();
};

} // namespace altiro3D::python

namespace pybind11::detail {

/// A type of the library that is a tuple of numbers.
template <class T, class Number, std::size_t count>
struct TupleCaster {
    using Numbers = std::array<Number, count>;
    bool load(handle source, bool convert) {
        if (!isinstance<sequence>(source) || isinstance<str>(source) || len(source) != count)
            return false;
        Numbers numbers{};
        for (std::size_t i = 0; i < count; ++i) {
            make_caster<Number> number;
            if (!number.load(source[int_(i)], convert)) return false;
            numbers[i] = cast_op<Number>(number);
        }
        value = made(numbers, std::make_index_sequence<count>());
        return true;
    }
    template <std::size_t... i>
    static T made(const Numbers& numbers, std::index_sequence<i...> /*indices*/) {
        return T(numbers[i]...);
    }
    T value{};
};

} // namespace pybind11::detail

/// Defines how a tuple of numbers becomes a type and back, `fields` being the type's numbers in
/// `v`.
#define ALTIRO3D_TUPLE(Type, Number, count, text, ...)                                             \
    template <>                                                                                    \
    struct pybind11::detail::type_caster<Type> : TupleCaster<Type, Number, count> {                \
        static constexpr auto name = const_name(text);                                             \
        template <class>                                                                           \
        using cast_op_type = Type;                                                                 \
        operator Type() { return value; }                                                          \
        static handle cast(const Type& v, return_value_policy /*policy*/, handle /*parent*/) {     \
            return make_tuple(__VA_ARGS__).release();                                              \
        }                                                                                          \
    };

// NOLINTBEGIN(readability-identifier-naming): the name is pybind11's
ALTIRO3D_TUPLE(cv::Size, int, 2, "Tuple[int, int]", v.width, v.height)
ALTIRO3D_TUPLE(cv::Point, int, 2, "Tuple[int, int]", v.x, v.y)
ALTIRO3D_TUPLE(cv::Range, int, 2, "Tuple[int, int]", v.start, v.end)
ALTIRO3D_TUPLE(cv::Point2d, double, 2, "Tuple[float, float]", v.x, v.y)
ALTIRO3D_TUPLE(cv::Rect, int, 4, "Tuple[int, int, int, int]", v.x, v.y, v.width, v.height)
// NOLINTEND(readability-identifier-naming)
#undef ALTIRO3D_TUPLE

namespace pybind11::detail {

template <>
struct type_caster<std::filesystem::path> {
    PYBIND11_TYPE_CASTER(std::filesystem::path, const_name("Union[str, os.PathLike]"));
    bool load(handle source, bool /*convert*/) {
        PyObject* bytes = nullptr;
        if (PyUnicode_FSConverter(source.ptr(), &bytes) == 0) {
            PyErr_Clear();
            return false;
        }
        value = std::string(reinterpret_steal<pybind11::bytes>(bytes));
        return true;
    }
    static handle cast(const std::filesystem::path& path, return_value_policy /*policy*/,
                       handle /*parent*/) {
        const std::string& own = path.native();
        const auto text = reinterpret_steal<object>(
            PyUnicode_DecodeFSDefaultAndSize(own.data(), static_cast<Py_ssize_t>(own.size())));
        return module_::import("pathlib").attr("Path")(text).release();
    }
};

template <>
struct type_caster<altiro3D::python::PathResult> {
    PYBIND11_TYPE_CASTER(altiro3D::python::PathResult, const_name("pathlib.Path"));
    static handle cast(const altiro3D::python::PathResult& result, return_value_policy policy,
                       handle parent) {
        return type_caster<std::filesystem::path>::cast(result.path, policy, parent);
    }
};

/// A ratio: fractions.Fraction, or a whole number.
template <>
struct type_caster<altiro3D::Fraction> {
    PYBIND11_TYPE_CASTER(altiro3D::Fraction, const_name("fractions.Fraction"));
    bool load(handle source, bool convert) {
        make_caster<int> numerator;
        make_caster<int> denominator;
        if (!hasattr(source, "denominator") || !numerator.load(source.attr("numerator"), convert) ||
            !denominator.load(source.attr("denominator"), convert))
            return false;
        value = {cast_op<int>(numerator), cast_op<int>(denominator)};
        return true;
    }
    static handle cast(const altiro3D::Fraction& ratio, return_value_policy /*policy*/,
                       handle /*parent*/) {
        return module_::import("fractions")
            .attr("Fraction")(ratio.numerator, ratio.denominator)
            .release();
    }
};

} // namespace pybind11::detail
