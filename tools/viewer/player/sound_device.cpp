#include "viewer/player/sound_device.hpp"

#ifdef ALTIRO3D_HAVE_SDL
#define SDL_MAIN_HANDLED
#include <SDL.h>
#include <dlfcn.h>
#include <mutex>
#endif

namespace altiro3D::viewer {

#ifdef ALTIRO3D_HAVE_SDL

namespace {

// SDL counts its users, but not thread-safely.
std::mutex& sdlMutex() {
    static std::mutex mutex;
    return mutex;
}

// Frees what SDL keeps for a thread that it did not start, such as the text of the last error.
struct ThreadCleanup {
    ThreadCleanup() = default;
    ThreadCleanup(const ThreadCleanup&) = delete;
    ThreadCleanup& operator=(const ThreadCleanup&) = delete;
    ~ThreadCleanup() { SDL_TLSCleanup(); }
};

void ignore(const char* /*file*/, int /*line*/, const char* /*function*/, int /*code*/,
            const char* /*format*/, ...) {}

// ALSA writes to standard error where there is no device; SDL says it as well.
void quietAlsa() {
    void* const alsa = dlopen("libasound.so.2", RTLD_LAZY); // stays loaded: SDL uses it
    void* const set = alsa != nullptr ? dlsym(alsa, "snd_lib_error_set_handler") : nullptr;
    if (set == nullptr) return;
    reinterpret_cast<int (*)(decltype(&ignore))>(set)(&ignore);
}

} // namespace

std::unique_ptr<SoundDevice> SoundDevice::open(std::function<void(float*, int)> fill,
                                               std::string& problem) {
    const std::lock_guard<std::mutex> lock(sdlMutex());
    const ThreadCleanup cleanup;
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1"); // Ctrl-C must end the program
    SDL_SetHint(SDL_HINT_APP_NAME, "altiro3D");
    quietAlsa();
    if (SDL_InitSubSystem(SDL_INIT_AUDIO) != 0) {
        problem = SDL_GetError();
        return nullptr;
    }
    std::unique_ptr<SoundDevice> device(new SoundDevice);
    device->fill_ = std::move(fill);
    SDL_AudioSpec wanted{};
    wanted.freq = kRate;
    wanted.format = AUDIO_F32SYS;
    wanted.channels = 2;
    wanted.samples = kPeriod;
    wanted.userdata = device.get();
    wanted.callback = [](void* self, Uint8* bytes, int size) {
        static_cast<SoundDevice*>(self)->fill_(reinterpret_cast<float*>(bytes),
                                               size / static_cast<int>(2 * sizeof(float)));
    };
    device->number_ = SDL_OpenAudioDevice(nullptr, 0, &wanted, nullptr, 0);
    if (device->number_ == 0) {
        problem = SDL_GetError();
        SDL_QuitSubSystem(SDL_INIT_AUDIO);
        return nullptr;
    }
    const std::string driver = SDL_GetCurrentAudioDriver();
    device->delay_ = driver == "disk" || driver == "dummy" ? 0 : kPeriod;
    SDL_PauseAudioDevice(device->number_, 0);
    return device;
}

SoundDevice::~SoundDevice() {
    if (number_ == 0) return;
    const std::lock_guard<std::mutex> lock(sdlMutex());
    const ThreadCleanup cleanup;
    SDL_CloseAudioDevice(number_);
    SDL_QuitSubSystem(SDL_INIT_AUDIO);
}

#else

std::unique_ptr<SoundDevice> SoundDevice::open(std::function<void(float*, int)> /*fill*/,
                                               std::string& problem) {
    problem = "this program was built without SDL";
    return nullptr;
}

SoundDevice::~SoundDevice() = default;

#endif

std::string soundProblem() {
    std::string problem;
    SoundDevice::open([](float*, int) {}, problem);
    return problem;
}

} // namespace altiro3D::viewer
