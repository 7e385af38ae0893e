#include "altiro3D/file_io.hpp"
#include "base/system_process.hpp"
#include "base/system_windows.hpp"

#include <array>

namespace altiro3D {

namespace {

// Closes what it holds at the end.
class Handle {
  public:
    explicit Handle(HANDLE handle) : handle_(handle) {}
    ~Handle() {
        if (handle_ != nullptr && handle_ != INVALID_HANDLE_VALUE) ::CloseHandle(handle_);
    }
    Handle(const Handle&) = delete;
    Handle& operator=(const Handle&) = delete;
    HANDLE get() const { return handle_; }

  private:
    HANDLE handle_;
};

// One argument as the C library of the new process takes it apart again.
std::wstring asArgument(const std::wstring& argument) {
    std::wstring text = L"\"";
    std::size_t slashes = 0;
    for (const wchar_t c : argument) {
        if (c == L'"') text.append(slashes + 1, L'\\');
        slashes = c == L'\\' ? slashes + 1 : 0;
        text += c;
    }
    return text.append(slashes, L'\\') + L'"';
}

std::wstring wide(const std::string& text) {
    return std::filesystem::path(text).native();
}

std::wstring commandLine(const std::vector<std::string>& program) {
    std::wstring name(std::size_t{1} << 15, L'\0');
    name.resize(::GetModuleFileNameW(nullptr, name.data(), static_cast<DWORD>(name.size())));
    std::wstring line = asArgument(name);
    for (const std::string& argument : program)
        line += L' ' + asArgument(wide(argument));
    return line;
}

} // namespace

std::int64_t processNumber() {
    return ::GetCurrentProcessId();
}

bool isRunning(std::int64_t process) {
    const auto number = static_cast<DWORD>(process);
    if (number != process) return true;
    const Handle handle(::OpenProcess(PROCESS_QUERY_LIMITED_INFORMATION, FALSE, number));
    if (handle.get() == nullptr) return ::GetLastError() != ERROR_INVALID_PARAMETER;
    DWORD status = 0;
    return ::GetExitCodeProcess(handle.get(), &status) == 0 || status == STILL_ACTIVE;
}

ApartEnd runApart(const std::function<void()>& work, const std::vector<std::string>& program,
                  double seconds) {
    ApartEnd end;
    if (program.empty()) {
        work();
        end.isInTime = end.isWhole = true;
        return end;
    }
    SECURITY_ATTRIBUTES inherited{sizeof inherited, nullptr, TRUE};
    const Handle nowhere(::CreateFileW(L"NUL", GENERIC_READ | GENERIC_WRITE,
                                       FILE_SHARE_READ | FILE_SHARE_WRITE, &inherited,
                                       OPEN_EXISTING, 0, nullptr));
    const Handle job(::CreateJobObjectW(nullptr, nullptr)); // its processes end with this one
    JOBOBJECT_EXTENDED_LIMIT_INFORMATION limits{};
    limits.BasicLimitInformation.LimitFlags =
        JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE | JOB_OBJECT_LIMIT_DIE_ON_UNHANDLED_EXCEPTION;
    ::SetInformationJobObject(job.get(), JobObjectExtendedLimitInformation, &limits, sizeof limits);
    STARTUPINFOW start{};
    start.cb = sizeof start;
    start.dwFlags = STARTF_USESTDHANDLES;
    start.hStdInput = start.hStdOutput = start.hStdError = nowhere.get();
    PROCESS_INFORMATION made{};
    std::wstring line = commandLine(program);
    if (::CreateProcessW(nullptr, line.data(), nullptr, nullptr, TRUE,
                         CREATE_NO_WINDOW | CREATE_SUSPENDED, nullptr, nullptr, &start,
                         &made) == 0) {
        end.error = lastErrno();
        return end;
    }
    const Handle process(made.hProcess);
    const Handle thread(made.hThread);
    ::AssignProcessToJobObject(job.get(), process.get());
    ::ResumeThread(thread.get());
    end.isInTime =
        ::WaitForSingleObject(process.get(), static_cast<DWORD>(seconds * 1000)) == WAIT_OBJECT_0;
    if (!end.isInTime) {
        ::TerminateProcess(process.get(), 1);
        ::WaitForSingleObject(process.get(), INFINITE);
        return end;
    }
    DWORD status = 0;
    ::GetExitCodeProcess(process.get(), &status);
    end.isWhole = status == 0;
    if (status == EXCEPTION_ACCESS_VIOLATION) end.how = " (access violation)";
    if (status == EXCEPTION_STACK_OVERFLOW) end.how = " (stack overflow)";
    return end;
}

std::string environmentOf(const char* name) {
    std::wstring value(std::size_t{1} << 15, L'\0');
    value.resize(::GetEnvironmentVariableW(wide(name).c_str(), value.data(),
                                           static_cast<DWORD>(value.size())));
    return std::filesystem::path(value).string();
}

const char kListSeparator = ';';
const char kShellQuote = '"';
const char* const kQuoteInShellQuotes = "\\\"";

std::filesystem::path userDataDirectory() {
    return environmentOf("LOCALAPPDATA");
}

std::tm localTime(std::time_t time) {
    std::tm local{};
    ::localtime_s(&local, &time);
    return local;
}

void requestLargePages(const void* /*begin*/, const void* /*end*/) {} // need a privilege

std::string hostName() {
    std::array<wchar_t, 256> name{};
    auto size = static_cast<DWORD>(name.size());
    if (::GetComputerNameExW(ComputerNameDnsHostname, name.data(), &size) == 0) return "unknown";
    return std::filesystem::path(name.data()).string();
}

} // namespace altiro3D
