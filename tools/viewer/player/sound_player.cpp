#include "viewer/player/sound_player.hpp"

#include "cli/system.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#ifdef ALTIRO3D_HAVE_SDL
#define SDL_MAIN_HANDLED
#include <SDL.h>
#include <mutex>
#endif

namespace altiro3D::viewer {

#ifdef ALTIRO3D_HAVE_SDL

namespace {

std::mutex sdlMutex;

// SDL counts its users, but not thread-safely. At the end it frees what SDL keeps for a thread that
// it did not start, such as the text of the last error.
struct SdlLock : std::lock_guard<std::mutex> {
    SdlLock() : lock_guard(sdlMutex) {}
    SdlLock(const SdlLock&) = delete;
    SdlLock& operator=(const SdlLock&) = delete;
    ~SdlLock() { SDL_TLSCleanup(); }
};

void ignore(const char* /*file*/, int /*line*/, const char* /*function*/, int /*code*/,
            const char* /*format*/, ...) {}

// ALSA writes to standard error where there is no device; SDL says it as well.
void quietAlsa() {
    void* const set = tools::functionOf("libasound.so.2", "snd_lib_error_set_handler");
    if (set == nullptr) return;
    reinterpret_cast<int (*)(decltype(&ignore))>(set)(&ignore);
}

} // namespace

SoundDevice::SoundDevice(std::function<void(float*, int)> fill) : fill_(std::move(fill)) {
    const SdlLock lock;
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1"); // Ctrl-C must end the program
    SDL_SetHint(SDL_HINT_APP_NAME, "altiro3D");
    quietAlsa();
    if (SDL_InitSubSystem(SDL_INIT_AUDIO) != 0) throw std::runtime_error(SDL_GetError());
    SDL_AudioSpec wanted{};
    wanted.freq = kRate;
    wanted.format = AUDIO_F32SYS;
    wanted.channels = 2;
    wanted.samples = kPeriod;
    wanted.userdata = this;
    wanted.callback = [](void* self, Uint8* bytes, int size) {
        static_cast<SoundDevice*>(self)->fill_(reinterpret_cast<float*>(bytes),
                                               size / static_cast<int>(2 * sizeof(float)));
    };
    number_ = SDL_OpenAudioDevice(nullptr, 0, &wanted, nullptr, 0);
    if (number_ == 0) {
        const std::string problem = SDL_GetError();
        SDL_QuitSubSystem(SDL_INIT_AUDIO);
        throw std::runtime_error(problem);
    }
    const std::string driver = SDL_GetCurrentAudioDriver();
    delay_ = driver == "disk" || driver == "dummy" ? 0 : kPeriod;
    SDL_PauseAudioDevice(number_, 0);
}

SoundDevice::~SoundDevice() {
    const SdlLock lock;
    SDL_CloseAudioDevice(number_);
    SDL_QuitSubSystem(SDL_INIT_AUDIO);
}

#else

SoundDevice::SoundDevice(std::function<void(float*, int)> /*fill*/) {
    throw std::runtime_error("this program was built without SDL");
}

SoundDevice::~SoundDevice() = default;

#endif

std::string soundProblem() {
    try {
        const SoundDevice device([](float*, int) {});
        return {};
    } catch (const std::exception& error) {
        return error.what();
    }
}

namespace {

constexpr std::size_t kChunk = 2048;         // samples that are read at a time
constexpr std::size_t kRing = 16 * kChunk;   // 0.7 s
constexpr double kRate = SoundDevice::kRate; // samples per second
constexpr double kUnheard = 1;               // s before the start, where time() waits for sound
constexpr std::chrono::milliseconds kStuck(2000); // without a call of the device

} // namespace

SoundPlayer::SoundPlayer(std::filesystem::path file)
    : file_(std::move(file)), ring_(2 * kRing),
      device_(std::make_unique<SoundDevice>(
          [this](float* samples, int count) { fill(samples, count); })) {
    thread_ = std::thread([this] { feed(); });
}

SoundPlayer::~SoundPlayer() {
    device_.reset();
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        ending_ = true;
    }
    wake_.notify_one();
    thread_.join();
}

void SoundPlayer::start(double from, int stream, double speed) {
    const std::lock_guard<std::mutex> lock(mutex_);
    wish_ = playing_ = {from, stream, speed};
    started_ = true;
    first_ = waiting_ = 0;
    taken_ = blockBegin_ = blockLength_ = 0;
    end_.reset();
    pausedAt_ = from;
    wake_.notify_one();
}

void SoundPlayer::setPaused(bool paused) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (paused && !paused_) pausedAt_ = timeLocked();
    paused_ = paused;
    lastCall_ = Clock::now();
}

void SoundPlayer::setVolume(double volume) {
    const std::lock_guard<std::mutex> lock(mutex_);
    volume_ = volume;
}

double SoundPlayer::time() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return timeLocked();
}

// The device takes a block while the one before is heard, unless it has no buffer.
double SoundPlayer::timeLocked() const {
    if (paused_) return pausedAt_;
    if (blockLength_ == 0) return playing_.from - kUnheard;
    const double since = std::chrono::duration<double>(Clock::now() - blockTime_).count();
    const double samples = static_cast<double>(blockBegin_) - device_->delay() +
                           std::min(since * kRate, static_cast<double>(blockLength_));
    return playing_.from + samples / kRate * playing_.speed;
}

bool SoundPlayer::isOver() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return end_ && timeLocked() >= *end_;
}

bool SoundPlayer::isStuck() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return !paused_ && Clock::now() - lastCall_ > kStuck;
}

void SoundPlayer::fill(float* samples, int count) {
    std::size_t done = 0;
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        lastCall_ = Clock::now();
        if (!paused_ && waiting_ > 0) {
            done = std::min(waiting_, static_cast<std::size_t>(count));
            for (std::size_t i = 0; i < 2 * done; ++i)
                samples[i] = static_cast<float>(volume_) * ring_[(2 * first_ + i) % ring_.size()];
            blockBegin_ = taken_;
            blockLength_ = static_cast<std::int64_t>(done);
            blockTime_ = lastCall_;
            taken_ += blockLength_;
            first_ = (first_ + done) % kRing;
            waiting_ -= done;
        }
    }
    std::fill(samples + 2 * done, samples + 2 * static_cast<std::size_t>(count), 0.F);
    wake_.notify_one();
}

// Opens the file where the reader at hand does not fit, else seeks in it.
void SoundPlayer::prepare(const Wish& wish) {
    if (reader_ && wish.stream == reading_.stream && wish.speed == reading_.speed)
        return reader_->seek(wish.from);
    reader_.reset();
    AudioReaderOptions options;
    options.stream = wish.stream;
    options.sampleRate = static_cast<int>(std::lround(kRate / wish.speed));
    options.from = wish.from;
    reader_ = std::make_unique<AudioReader>(file_, options);
    reading_ = wish;
}

void SoundPlayer::feed() {
    std::vector<float> chunk(2 * kChunk);
    std::int64_t made = 0; // since the start
    for (;;) {
        std::optional<Wish> wish;
        std::unique_lock<std::mutex> lock(mutex_);
        wake_.wait(lock,
                   [this] { return ending_ || wish_ || (started_ && waiting_ + kChunk <= kRing); });
        if (ending_) return;
        wish.swap(wish_);
        lock.unlock();
        std::size_t count = 0;
        try {
            if (wish) {
                made = 0;
                prepare(*wish);
            }
            if (reader_) count = reader_->read(chunk.data(), kChunk);
        } catch (const std::exception&) { // what cannot be read is silent
            reader_.reset();
        }
        std::fill(chunk.begin() + static_cast<std::ptrdiff_t>(2 * count), chunk.end(), 0.F);
        lock.lock();
        if (wish_) continue;
        if (count < kChunk && !end_)
            end_ = playing_.from + static_cast<double>(made + static_cast<std::int64_t>(count)) /
                                       kRate * playing_.speed;
        made += kChunk;
        const std::size_t at = 2 * ((first_ + waiting_) % kRing);
        for (std::size_t i = 0; i < chunk.size(); ++i)
            ring_[(at + i) % ring_.size()] = chunk[i];
        waiting_ += kChunk;
    }
}

} // namespace altiro3D::viewer
