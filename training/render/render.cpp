// Renders frames with exact inverse depth for training. Python calls it through ctypes (render.py).
//
// Light: one sun with a disc, small lamps, and the rest from a blurred panorama, seen past whatever
// is nearer than `ambientReach`. Enough for shading that a photo could have; no further bounces.
// World: metres, z up. Depth is the distance along the optical axis.

#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <vector>

namespace {

constexpr float pi = 3.14159265358979F;

struct Vec {
    float x = 0, y = 0, z = 0;
};
Vec operator+(Vec a, Vec b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
Vec operator-(Vec a, Vec b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
Vec operator*(Vec a, float s) {
    return {a.x * s, a.y * s, a.z * s};
}
Vec operator*(Vec a, Vec b) {
    return {a.x * b.x, a.y * b.y, a.z * b.z};
}
float dot(Vec a, Vec b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
Vec cross(Vec a, Vec b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
float length(Vec a) {
    return std::sqrt(dot(a, a));
}
Vec unit(Vec a) {
    const float l = length(a);
    return l > 0 ? a * (1 / l) : Vec{0, 0, 1};
}

/// A random number generator that costs nothing (PCG).
struct Random {
    std::uint64_t state;
    float next() {
        state = state * 6364136223846793005ULL + 1442695040888963407ULL;
        const auto shifted = static_cast<std::uint32_t>(((state >> 18U) ^ state) >> 27U);
        const auto turn = static_cast<std::uint32_t>(state >> 59U);
        const std::uint32_t bits = (shifted >> turn) | (shifted << ((32U - turn) & 31U));
        return static_cast<float>(bits >> 8U) * (1.0F / 16777216.0F);
    }
};

float linearOf(int value) {
    static const auto table = [] {
        std::array<float, 256> t{};
        for (int i = 0; i < 256; ++i) {
            const float v = static_cast<float>(i) / 255;
            t[static_cast<std::size_t>(i)] =
                v <= 0.04045F ? v / 12.92F : std::pow((v + 0.055F) / 1.055F, 2.4F);
        }
        return t;
    }();
    return table[static_cast<std::size_t>(value)];
}

struct Colour {
    Vec rgb;
    float alpha = 1;
};

/// An sRGB picture with transparency, and its smaller copies. It repeats in both directions.
struct Texture {
    struct Level {
        int width = 0, height = 0;
        std::vector<std::uint8_t> rgba;
    };
    std::vector<Level> levels;

    Texture(const std::uint8_t* rgba, int width, int height) {
        levels.push_back(
            {width, height, {rgba, rgba + static_cast<std::size_t>(width) * height * 4}});
        while (levels.back().width > 1 && levels.back().height > 1) {
            const Level& big = levels.back();
            Level small{big.width / 2, big.height / 2, {}};
            small.rgba.resize(static_cast<std::size_t>(small.width) * small.height * 4);
            for (int y = 0; y < small.height; ++y)
                for (int x = 0; x < small.width; ++x)
                    for (int c = 0; c < 4; ++c) {
                        int sum = 2;
                        for (int k = 0; k < 4; ++k)
                            sum += big.rgba[(static_cast<std::size_t>(2 * y + k / 2) * big.width +
                                             2 * x + k % 2) *
                                                4 +
                                            c];
                        small.rgba[(static_cast<std::size_t>(y) * small.width + x) * 4 + c] =
                            static_cast<std::uint8_t>(sum / 4);
                    }
            levels.push_back(std::move(small));
        }
    }

    Colour at(float u, float v, float lod) const {
        const auto top = static_cast<float>(levels.size() - 1);
        const Level& l = levels[static_cast<std::size_t>(std::clamp(lod + 0.5F, 0.0F, top))];
        const float x = (u - std::floor(u)) * static_cast<float>(l.width) - 0.5F;
        const float y = (v - std::floor(v)) * static_cast<float>(l.height) - 0.5F;
        const float fx = x - std::floor(x), fy = y - std::floor(y);
        const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
        Colour out{{}, 0};
        for (int k = 0; k < 4; ++k) {
            const int xx = ((x0 + k % 2) % l.width + l.width) % l.width;
            const int yy = ((y0 + k / 2) % l.height + l.height) % l.height;
            const float w = (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy);
            const std::uint8_t* p = &l.rgba[(static_cast<std::size_t>(yy) * l.width + xx) * 4];
            out.rgb = out.rgb + Vec{linearOf(p[0]), linearOf(p[1]), linearOf(p[2])} * w;
            out.alpha += w * static_cast<float>(p[3]) / 255;
        }
        return out;
    }
};

/// A panorama: column 0 looks along +x, columns run clockwise seen from above, row 0 is the zenith.
struct Panorama {
    int width = 0, height = 0;
    std::vector<float> rgb;

    Vec at(Vec d, float turn) const {
        float u = (-std::atan2(d.y, d.x) + turn) / (2 * pi);
        u -= std::floor(u);
        const float v = std::acos(std::clamp(d.z, -1.0F, 1.0F)) / pi;
        const float x = u * static_cast<float>(width) - 0.5F,
                    y = v * static_cast<float>(height) - 0.5F;
        const float fx = x - std::floor(x), fy = y - std::floor(y);
        const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
        Vec sum;
        for (int k = 0; k < 4; ++k) {
            const int xx = ((x0 + k % 2) % width + width) % width;
            const int yy = std::clamp(y0 + k / 2, 0, height - 1);
            const float* p = &rgb[(static_cast<std::size_t>(yy) * width + xx) * 3];
            sum = sum + Vec{p[0], p[1], p[2]} * ((k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy));
        }
        return sum;
    }
};

enum class Paint : int { Uv = 0, Solid = 1, Panorama = 2, UnlitUv = 3 };

/// Mirrors the array of floats that render.py fills.
struct Material {
    float rgb[3];
    float texture;     // number of the texture, -1: none
    float scale;       // factor on texture coordinates; for Solid: repetitions per metre
    float paint;       // Paint
    float gloss;       // strength of the highlight
    float sharpness;   // its exponent
    float detail;      // number of a texture that modulates the colour, -1: none
    float detailScale; // repetitions per metre
    float detailStrength;
    float
        flags; // 1: transparent where the texture is; 2: sky (inverse depth 0); 4: no shadow on it
};

struct Model {
    RTCScene scene = nullptr;
    std::vector<Vec> positions, normals;
    std::vector<float> uv;
    std::vector<std::int32_t> triangles, materials;
    std::vector<float> uvPerMetre; // of each triangle
};

struct Instance {
    const Model* model;
    std::size_t firstMaterial;
    float m[12]; // rows of a 3 x 4 matrix
    float scale;
};

struct World {
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
    std::vector<std::unique_ptr<Texture>> textures; // by number
    std::map<int, std::unique_ptr<Panorama>> panoramas;
    std::map<int, std::unique_ptr<Model>> models;
    int nextId = 0;
    std::vector<Instance> instances; // of the frame being rendered
    std::vector<Material> materials;
};

World& world() {
    static World w;
    return w;
}

/// The light on a point, to be taken over by its neighbour.
struct Shade {
    unsigned instance = RTC_INVALID_GEOMETRY_ID;
    Vec normal, direct, highlight;
};

const Material& materialOf(const Instance& instance, unsigned triangle) {
    return world().materials[instance.firstMaterial +
                             static_cast<std::size_t>(instance.model->materials[triangle])];
}

void uvAt(const Model& m, unsigned triangle, float u, float v, float out[2]) {
    const std::int32_t* t = &m.triangles[static_cast<std::size_t>(triangle) * 3];
    for (int k = 0; k < 2; ++k)
        out[k] = m.uv[static_cast<std::size_t>(t[0]) * 2 + k] * (1 - u - v) +
                 m.uv[static_cast<std::size_t>(t[1]) * 2 + k] * u +
                 m.uv[static_cast<std::size_t>(t[2]) * 2 + k] * v;
}

/// Lets rays pass where a texture is transparent.
void passTransparent(const RTCFilterFunctionNArguments* a) {
    const unsigned which = RTCHitN_instID(a->hit, a->N, 0, 0);
    if (which >= world().instances.size()) return;
    const Instance& instance = world().instances[which];
    const unsigned triangle = RTCHitN_primID(a->hit, a->N, 0);
    const Material& material = materialOf(instance, triangle);
    if ((static_cast<int>(material.flags) & 1) == 0 || material.texture < 0) return;
    float uv[2];
    uvAt(*instance.model, triangle, RTCHitN_u(a->hit, a->N, 0), RTCHitN_v(a->hit, a->N, 0), uv);
    const Texture::Level& l =
        world().textures[static_cast<std::size_t>(material.texture)]->levels[0];
    const float u = uv[0] * material.scale, v = uv[1] * material.scale;
    const auto x =
        static_cast<std::size_t>((u - std::floor(u)) * static_cast<float>(l.width - 1) + 0.5F);
    const auto y =
        static_cast<std::size_t>((v - std::floor(v)) * static_cast<float>(l.height - 1) + 0.5F);
    if (l.rgba[(y * static_cast<std::size_t>(l.width) + x) * 4 + 3] < 128) a->valid[0] = 0;
}

RTCRayHit makeRay(Vec from, Vec direction, float far) {
    RTCRayHit r{};
    r.ray.org_x = from.x, r.ray.org_y = from.y, r.ray.org_z = from.z;
    r.ray.dir_x = direction.x, r.ray.dir_y = direction.y, r.ray.dir_z = direction.z;
    r.ray.tnear = 0, r.ray.tfar = far;
    r.ray.mask = 0xFFFFFFFFU;
    r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return r;
}

/// A direction around `axis`, weighted by the cosine.
Vec cosineDirection(Vec axis, float a, float b) {
    const Vec side =
        unit(std::abs(axis.z) < 0.9F ? cross(axis, {0, 0, 1}) : cross(axis, {1, 0, 0}));
    const Vec up = cross(axis, side);
    const float r = std::sqrt(a), angle = 2 * pi * b;
    return side * (r * std::cos(angle)) + up * (r * std::sin(angle)) +
           axis * std::sqrt(std::max(0.0F, 1 - a));
}

/// Light on the pixels from all around is noisy. This averages it over neighbours on the same
/// surface.
void smoothAmbient(int width, int height, const std::vector<float>& inverse,
                   const std::vector<Vec>& normal, std::vector<Vec>& light) {
    std::vector<Vec> out(light.size());
    for (int pass = 0; pass < 2; ++pass) {
        const int step = pass == 0 ? 1 : 3;
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const auto here = static_cast<std::size_t>(y) * width + x;
                Vec sum;
                float weights = 0;
                for (int dy = -1; dy <= 1; ++dy)
                    for (int dx = -1; dx <= 1; ++dx) {
                        const int xx = x + dx * step, yy = y + dy * step;
                        if (xx < 0 || yy < 0 || xx >= width || yy >= height) continue;
                        const auto there = static_cast<std::size_t>(yy) * width + xx;
                        const float apart = std::abs(inverse[there] - inverse[here]);
                        if (apart > 0.04F * (inverse[here] + 1e-6F)) continue;
                        const float same = std::max(0.0F, dot(normal[here], normal[there]));
                        const float w = same * same * same * same;
                        sum = sum + light[there] * w;
                        weights += w;
                    }
                out[here] = weights > 0 ? sum * (1 / weights) : light[here];
            }
        light.swap(out);
    }
}

} // namespace

extern "C" {

/// Mirrors the structure of the same name in render.py.
struct View {
    float position[3];
    float axes[9]; // right, down, forward
    float focal;   // px
    float centre[2];
    std::int32_t width, height, samples; // samples per pixel: 1, 2 or 4
    std::int32_t background;             // panorama behind everything and as light
    float turn;                          // of the panorama, radians
    float exposure;                      // factor on the panorama
    float lightScale;                    // factor on its light on surfaces
    float ambientReach;                  // metres; what is farther does not shade
    float projector[3];                  // where the panorama was taken, for Paint::Panorama
    float sun[3];                        // direction to it
    float sunColour[3];
    float sunSize; // radians
    float fog;     // per metre
    float fogColour[3];
    std::uint32_t seed;
};

int addTexture(const std::uint8_t* rgba, int width, int height) {
    world().textures.push_back(std::make_unique<Texture>(rgba, width, height));
    return static_cast<int>(world().textures.size()) - 1;
}

int addPanorama(const float* rgb, int width, int height) {
    const int id = world().nextId++;
    auto p = std::make_unique<Panorama>();
    p->width = width, p->height = height;
    p->rgb.assign(rgb, rgb + static_cast<std::size_t>(width) * height * 3);
    world().panoramas[id] = std::move(p);
    return id;
}

int addModel(const float* positions, const float* normals, const float* uv, int vertices,
             const std::int32_t* triangles, const std::int32_t* materials, int count,
             int transparent) {
    auto model = std::make_unique<Model>();
    const auto* p = reinterpret_cast<const Vec*>(positions);
    const auto* n = reinterpret_cast<const Vec*>(normals);
    model->positions.assign(p, p + vertices);
    model->normals.assign(n, n + vertices);
    model->uv.assign(uv, uv + static_cast<std::size_t>(vertices) * 2);
    model->triangles.assign(triangles, triangles + static_cast<std::size_t>(count) * 3);
    model->materials.assign(materials, materials + count);
    for (int t = 0; t < count; ++t) {
        const std::int32_t* i = triangles + static_cast<std::size_t>(t) * 3;
        const float area = length(cross(p[i[1]] - p[i[0]], p[i[2]] - p[i[0]]));
        const float* a = uv + static_cast<std::size_t>(i[0]) * 2;
        const float* b = uv + static_cast<std::size_t>(i[1]) * 2;
        const float* c = uv + static_cast<std::size_t>(i[2]) * 2;
        const float inUv = std::abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
        model->uvPerMetre.push_back(std::sqrt(inUv / std::max(area, 1e-12F)));
    }
    RTCDevice device = world().device;
    model->scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                          RTC_FORMAT_FLOAT3, 12,
                                                          static_cast<std::size_t>(vertices)));
    std::copy(positions, positions + static_cast<std::size_t>(vertices) * 3, v);
    auto* i = static_cast<std::int32_t*>(rtcSetNewGeometryBuffer(
        geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, static_cast<std::size_t>(count)));
    std::copy(triangles, triangles + static_cast<std::size_t>(count) * 3, i);
    if (transparent != 0) {
        rtcSetGeometryIntersectFilterFunction(geometry, passTransparent);
        rtcSetGeometryOccludedFilterFunction(geometry, passTransparent);
    }
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(model->scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(model->scene);
    const int id = world().nextId++;
    world().models[id] = std::move(model);
    return id;
}

void dropModel(int id) {
    const auto found = world().models.find(id);
    if (found == world().models.end()) return;
    rtcReleaseScene(found->second->scene);
    world().models.erase(found);
}

/// Renders `count` instances. `instances` has 14 numbers each: model, first material, 3 x 4 matrix.
/// `lamps` has 7: position, radius, colour. Writes linear colour, inverse depth (1 / metres), and
/// the instance or -1 of each pixel.
void render(const View* view, const float* instances, int count, const float* materials,
            int materialCount, const float* lamps, int lampCount, const float* blurred,
            int blurredWidth, int blurredHeight, float* colour, float* inverse,
            std::int32_t* which) {
    World& w = world();
    const auto* m = reinterpret_cast<const Material*>(materials);
    w.materials.assign(m, m + materialCount);
    w.instances.clear();
    RTCScene scene = rtcNewScene(w.device);
    for (int k = 0; k < count; ++k) {
        const float* in = instances + static_cast<std::size_t>(k) * 14;
        Instance instance{
            w.models.at(static_cast<int>(in[0])).get(), static_cast<std::size_t>(in[1]), {}, 1};
        std::copy(in + 2, in + 14, instance.m);
        const float* a = instance.m;
        const float det = a[0] * (a[5] * a[10] - a[6] * a[9]) -
                          a[1] * (a[4] * a[10] - a[6] * a[8]) + a[2] * (a[4] * a[9] - a[5] * a[8]);
        instance.scale = std::cbrt(std::max(std::abs(det), 1e-12F));
        w.instances.push_back(instance);
        RTCGeometry geometry = rtcNewGeometry(w.device, RTC_GEOMETRY_TYPE_INSTANCE);
        rtcSetGeometryInstancedScene(geometry, instance.model->scene);
        rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, instance.m);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(scene, geometry, static_cast<unsigned>(k));
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(scene);

    Panorama soft;
    soft.width = blurredWidth, soft.height = blurredHeight;
    soft.rgb.assign(blurred, blurred + static_cast<std::size_t>(blurredWidth) * blurredHeight * 3);
    const Panorama& background = *w.panoramas.at(view->background);
    const auto vec = [](const float* p) { return Vec{p[0], p[1], p[2]}; };
    const Vec eye = vec(view->position), right = vec(view->axes), down = vec(view->axes + 3),
              forward = vec(view->axes + 6), sun = vec(view->sun), sunColour = vec(view->sunColour),
              projector = vec(view->projector), fogColour = vec(view->fogColour);
    const int width = view->width, height = view->height, samples = view->samples;
    const float side = std::sqrt(static_cast<float>(samples));
    const auto pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    std::vector<Vec> direct(pixels), albedo(pixels), ambient(pixels), normals(pixels);
    std::vector<float> nearest(static_cast<std::size_t>(samples));
    std::vector<std::pair<float, int>> hits(static_cast<std::size_t>(samples));
    Random random{0x9E3779B97F4A7C15ULL * (view->seed + 1ULL)};
    for (int k = 0; k < 8; ++k)
        random.next();
    const float far = std::numeric_limits<float>::infinity();
    Vec average;
    for (int k = 0; k < 16; ++k) {
        const float z = 1 - (static_cast<float>(k) + 0.5F) / 8, r = std::sqrt(1 - z * z),
                    angle = 2.4F * static_cast<float>(k);
        average = average +
                  soft.at({r * std::cos(angle), r * std::sin(angle), z}, view->turn) * (1.0F / 16);
    }

    const float sunLuma = sunColour.x + sunColour.y + sunColour.z;
    const auto occluded = [&](Vec from, Vec direction, float reach) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRay ray = makeRay(from, direction, reach).ray;
        rtcOccluded1(scene, &context, &ray);
        return ray.tfar < 0;
    };

    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const auto here = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                              static_cast<std::size_t>(x);
            int shaded = 0;
            Shade
                last; // three of four samples take the light of the one before, on the same surface
            for (int s = 0; s < samples; ++s) {
                // Two samples lie on a diagonal, four on a grid; each anywhere in its part.
                const int column = s % 2, row = samples == 2 ? (s ^ ((x + y) & 1)) : s / 2;
                const float parts = samples == 1 ? 1 : 2;
                const float px =
                    static_cast<float>(x) + (static_cast<float>(column) + random.next()) / parts;
                const float py =
                    static_cast<float>(y) + (static_cast<float>(row) + random.next()) / parts;
                const Vec d = unit(right * ((px - view->centre[0]) / view->focal) +
                                   down * ((py - view->centre[1]) / view->focal) + forward);
                RTCIntersectContext context;
                rtcInitIntersectContext(&context);
                RTCRayHit ray = makeRay(eye, d, far);
                rtcIntersect1(scene, &context, &ray);
                hits[static_cast<std::size_t>(s)] = {0.0F, -1};
                if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
                    direct[here] = direct[here] + background.at(d, view->turn) * view->exposure;
                    continue;
                }
                const Instance& instance = w.instances[ray.hit.instID[0]];
                const Model& model = *instance.model;
                const unsigned triangle = ray.hit.primID;
                const Material& material = materialOf(instance, triangle);
                const int flags = static_cast<int>(material.flags);
                const float t = ray.ray.tfar;
                const Vec point = eye + d * t;
                if ((flags & 2) == 0)
                    hits[static_cast<std::size_t>(s)] = {1 / (t * dot(d, forward)),
                                                         static_cast<int>(ray.hit.instID[0])};
                const std::int32_t* i = &model.triangles[static_cast<std::size_t>(triangle) * 3];
                const float b1 = ray.hit.u, b2 = ray.hit.v, b0 = 1 - b1 - b2;
                const auto corner = [&](const std::vector<Vec>& of, int k) {
                    return of[static_cast<std::size_t>(i[k])];
                };
                const float* a = instance.m;
                const auto turned =
                    [&](Vec n) { // normals: the matrices here rotate and scale by nearly one factor
                        return unit({a[0] * n.x + a[1] * n.y + a[2] * n.z,
                                     a[4] * n.x + a[5] * n.y + a[6] * n.z,
                                     a[8] * n.x + a[9] * n.y + a[10] * n.z});
                    };
                Vec face = turned({ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z});
                Vec n = turned(corner(model.normals, 0) * b0 + corner(model.normals, 1) * b1 +
                               corner(model.normals, 2) * b2);
                if (dot(face, d) > 0) face = face * -1;
                if (dot(n, face) < 0) n = n * -1;
                if (dot(n, d) > -0.02F) n = unit(n - d * (dot(n, d) + 0.02F));
                const Vec local = corner(model.positions, 0) * b0 +
                                  corner(model.positions, 1) * b1 + corner(model.positions, 2) * b2;
                const float footprint =
                    t / view->focal / std::sqrt(std::max(0.05F, -dot(d, face))) / side * 1.4F;

                const auto solid = [&](const Texture& texture,
                                       float perMetre) { // from the three sides
                    const Vec p = local * instance.scale * perMetre;
                    const Vec ln =
                        unit(cross(corner(model.positions, 1) - corner(model.positions, 0),
                                   corner(model.positions, 2) - corner(model.positions, 0)));
                    const float lod = std::log2(std::max(
                        1.0F, footprint * perMetre * static_cast<float>(texture.levels[0].width)));
                    if (std::abs(ln.z) > std::abs(ln.x) && std::abs(ln.z) > std::abs(ln.y))
                        return texture.at(p.x, p.y, lod);
                    if (std::abs(ln.x) > std::abs(ln.y)) return texture.at(p.y, -p.z, lod);
                    return texture.at(p.x, -p.z, lod);
                };
                Vec base{material.rgb[0], material.rgb[1], material.rgb[2]};
                const auto paint = static_cast<Paint>(static_cast<int>(material.paint));
                if (material.texture >= 0) {
                    const Texture& texture =
                        *w.textures[static_cast<std::size_t>(material.texture)];
                    if (paint == Paint::Solid)
                        base = base * solid(texture, material.scale).rgb;
                    else if (paint != Paint::Panorama) {
                        float uv[2];
                        uvAt(model, triangle, b1, b2, uv);
                        const float texels = model.uvPerMetre[triangle] / instance.scale *
                                             std::abs(material.scale) *
                                             static_cast<float>(texture.levels[0].width);
                        base = base * texture
                                          .at(uv[0] * material.scale, uv[1] * material.scale,
                                              std::log2(std::max(1.0F, footprint * texels)))
                                          .rgb;
                    }
                }
                if (paint == Paint::Panorama)
                    base =
                        base * background.at(unit(point - projector), view->turn) * view->exposure;
                if (material.detail >= 0) {
                    const Vec c = solid(*w.textures[static_cast<std::size_t>(material.detail)],
                                        material.detailScale)
                                      .rgb;
                    const float grey =
                        std::pow((c.x + c.y + c.z) / 3 / 0.2F + 0.02F, material.detailStrength);
                    base = base * std::clamp(grey, 0.2F, 3.0F);
                }

                const Vec start = point + face * (2e-4F + t * 1e-4F);
                Vec lit;
                if (paint == Paint::UnlitUv || (flags & 4) != 0) {
                    lit = base;
                    base = {};
                } else if (s % 4 != 0 && last.instance == ray.hit.instID[0] &&
                           dot(n, last.normal) > 0.95F) {
                    lit = base * last.direct + last.highlight;
                } else {
                    last = {ray.hit.instID[0], n, {}, {}};
                    const Vec jitter = cosineDirection(
                        sun, random.next() * view->sunSize * view->sunSize, random.next());
                    const float facing = dot(n, jitter);
                    const bool toSun = sunLuma > 0 && facing > 0;
                    const bool open = toSun && !occluded(start, jitter, far);
                    const bool photo =
                        paint ==
                        Paint::Panorama; // it has its light; what stands on it takes some away
                    const auto add = [&](Vec power, Vec to) {
                        last.direct = last.direct + power * dot(n, to);
                        if (material.gloss > 0)
                            last.highlight = last.highlight +
                                             power * (material.gloss *
                                                      std::pow(std::max(0.0F, dot(n, unit(to - d))),
                                                               material.sharpness));
                    };
                    if (open && !photo) add(sunColour, jitter);
                    for (int k = 0; k < lampCount && !photo; ++k) {
                        const float* l = lamps + static_cast<std::size_t>(k) * 7;
                        const Vec spread{random.next() - 0.5F, random.next() - 0.5F,
                                         random.next() - 0.5F};
                        const Vec way = vec(l) + spread * (2 * l[3]) - point;
                        const float distance = length(way);
                        const Vec to = way * (1 / distance);
                        if (dot(n, to) <= 0 || occluded(start, to, distance * 0.98F)) continue;
                        add(vec(l + 4) * (1 / (distance * distance + 0.05F)), to);
                    }
                    const float strata =
                        (static_cast<float>(s) + random.next()) / static_cast<float>(samples);
                    const Vec to = cosineDirection(n, strata, random.next());
                    const bool hidden = occluded(start, to, view->ambientReach);
                    const Vec around = photo ? Vec{1, 1, 1} * ((hidden ? 0.25F : 1.0F) *
                                                               (toSun && !open ? 0.45F : 1.0F))
                                             : (hidden ? average * 0.3F : soft.at(to, view->turn)) *
                                                   view->lightScale;
                    ambient[here] = ambient[here] + around;
                    ++shaded;
                    lit = base * last.direct + last.highlight;
                }
                const float clear = view->fog > 0 ? std::exp(-view->fog * t) : 1.0F;
                direct[here] = direct[here] + lit * clear + fogColour * (1 - clear);
                albedo[here] = albedo[here] + base * clear;
                normals[here] = normals[here] + n;
            }
            // Depth of the nearest surface that covers at least half of the pixel.
            std::sort(hits.begin(), hits.end(),
                      [](const auto& l, const auto& r) { return l.first > r.first; });
            const auto& chosen = hits[static_cast<std::size_t>((samples - 1) / 2)];
            inverse[here] = chosen.first;
            which[here] = chosen.second;
            const float share = 1.0F / static_cast<float>(samples);
            direct[here] = direct[here] * share;
            albedo[here] = albedo[here] * share;
            ambient[here] = ambient[here] * (1.0F / static_cast<float>(std::max(shaded, 1)));
            normals[here] = unit(normals[here]);
        }
    smoothAmbient(width, height, std::vector<float>(inverse, inverse + pixels), normals, ambient);
    for (std::size_t k = 0; k < pixels; ++k) {
        const Vec c = direct[k] + albedo[k] * ambient[k];
        colour[k * 3] = c.x, colour[k * 3 + 1] = c.y, colour[k * 3 + 2] = c.z;
    }
    rtcReleaseScene(scene);
}
}
