#include "support/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <opencv2/core/utility.hpp>

namespace altiro3D::test {

namespace {

using Vec = cv::Vec3d;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kEpsilon = 1e-6; // m; how far a secondary ray starts off its surface
constexpr double kPi = 3.14159265358979323846;

Vec normalized(const Vec& v) {
    return v * (1 / std::sqrt(v.dot(v)));
}

Vec mix(const Vec& a, const Vec& b, double weight) {
    return a + (b - a) * weight;
}

Vec multiply(const Vec& a, const Vec& b) {
    return {a[0] * b[0], a[1] * b[1], a[2] * b[2]};
}

double smoothStep(double low, double high, double x) {
    const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

// --- Noise: a hash of integers, never rand() -------------------------------------------------

double hash(std::int64_t x, std::int64_t y, std::int64_t z) {
    auto h = static_cast<std::uint64_t>(x) * 0x9e3779b97f4a7c15U ^
             static_cast<std::uint64_t>(y) * 0xc2b2ae3d27d4eb4fU ^
             static_cast<std::uint64_t>(z) * 0x165667b19e3779f9U;
    h = (h ^ (h >> 31U)) * 0xff51afd7ed558ccdU;
    h = (h ^ (h >> 29U)) * 0xc4ceb9fe1a85ec53U;
    return static_cast<double>((h ^ (h >> 32U)) >> 11U) * 0x1p-53;
}

// Value noise, 0..1.
double noise(const Vec& p) {
    std::int64_t cell[3];
    double part[3];
    for (int i = 0; i < 3; ++i) {
        const double low = std::floor(p[i]);
        cell[i] = static_cast<std::int64_t>(low);
        const double t = p[i] - low;
        part[i] = t * t * (3 - 2 * t);
    }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1;
        std::int64_t at[3];
        for (int i = 0; i < 3; ++i) {
            const bool upper = ((corner >> i) & 1) != 0;
            at[i] = cell[i] + (upper ? 1 : 0);
            weight *= upper ? part[i] : 1 - part[i];
        }
        sum += weight * hash(at[0], at[1], at[2]);
    }
    return sum;
}

// Sum of octaves, 0..1.
double cloudNoise(Vec p, int octaves) {
    double sum = 0;
    double weight = 0.5;
    double total = 0;
    for (int i = 0; i < octaves; ++i) {
        sum += weight * noise(p);
        total += weight;
        weight *= 0.5;
        p = p * 2.03 + Vec(17.1, 3.7, 9.2);
    }
    return sum / total;
}

// --- Intersections ---------------------------------------------------------------------------

struct Ray {
    Vec origin;
    Vec direction; // any length; distances along the ray are in its units
};

struct Hit {
    double distance = kInfinity;
    const Solid* solid = nullptr;
    Vec normal; // outward, unit length
    Vec local;  // the place relative to the solid's centre, in its own axes
};

// A solid with what its intersection needs again and again.
struct Prepared {
    const Solid* solid = nullptr;
    double cosYaw = 1;
    double sinYaw = 0;
    double boundRadius = 0; // of a sphere about the centre
};

Prepared prepare(const Solid& solid) {
    Prepared prepared;
    prepared.solid = &solid;
    if (solid.form == Form::Box) {
        prepared.cosYaw = std::cos(solid.yawDegrees * kPi / 180);
        prepared.sinYaw = std::sin(solid.yawDegrees * kPi / 180);
    }
    const Vec& half = solid.half;
    switch (solid.form) {
    case Form::Ellipsoid:
        prepared.boundRadius = std::max({half[0], half[1], half[2]});
        break;
    case Form::Box:
        prepared.boundRadius = cv::norm(half);
        break;
    case Form::Frustum:
        prepared.boundRadius = std::hypot(half[1], std::max(half[0], half[2]));
        break;
    case Form::Plane:
        prepared.boundRadius = kInfinity;
        break;
    }
    return prepared;
}

// Into the solid's own axes, and back with the other sign of sinYaw.
Vec turned(const Vec& v, double cosYaw, double sinYaw) {
    return {cosYaw * v[0] - sinYaw * v[2], v[1], sinYaw * v[0] + cosYaw * v[2]};
}

// The smaller root of a t^2 + 2 b t + c = 0 beyond `from`, else the larger one, else infinity.
double firstRoot(double a, double b, double c, double from) {
    const double discriminant = b * b - a * c;
    if (discriminant < 0 || a == 0) return kInfinity;
    const double root = std::sqrt(discriminant);
    const double low = std::min((-b - root) / a, (-b + root) / a);
    if (low > from) return low;
    const double high = std::max((-b - root) / a, (-b + root) / a);
    return high > from ? high : kInfinity;
}

void hitEllipsoid(const Vec& o, const Vec& d, const Vec& half, double from, Hit& hit) {
    const Vec so(o[0] / half[0], o[1] / half[1], o[2] / half[2]);
    const Vec sd(d[0] / half[0], d[1] / half[1], d[2] / half[2]);
    const double t = firstRoot(sd.dot(sd), so.dot(sd), so.dot(so) - 1, from);
    if (t >= hit.distance) return;
    hit.distance = t;
    hit.local = o + d * t;
    hit.normal =
        normalized(Vec(hit.local[0] / (half[0] * half[0]), hit.local[1] / (half[1] * half[1]),
                       hit.local[2] / (half[2] * half[2])));
}

void hitBox(const Vec& o, const Vec& d, const Vec& half, double from, Hit& hit) {
    double enter = -kInfinity;
    double leave = kInfinity;
    int enterAxis = 0;
    int leaveAxis = 0;
    for (int i = 0; i < 3; ++i) {
        if (d[i] == 0) {
            if (std::abs(o[i]) > half[i]) return;
            continue;
        }
        const double a = (-half[i] - o[i]) / d[i];
        const double b = (half[i] - o[i]) / d[i];
        if (std::min(a, b) > enter) {
            enter = std::min(a, b);
            enterAxis = i;
        }
        if (std::max(a, b) < leave) {
            leave = std::max(a, b);
            leaveAxis = i;
        }
    }
    if (enter > leave) return;
    const bool outside = enter > from;
    const double t = outside ? enter : leave;
    if (t <= from || t >= hit.distance) return;
    const int axis = outside ? enterAxis : leaveAxis;
    hit.distance = t;
    hit.local = o + d * t;
    hit.normal = Vec(0, 0, 0);
    hit.normal[axis] = hit.local[axis] > 0 ? 1 : -1;
}

void hitFrustum(const Vec& o, const Vec& d, const Vec& half, double from, Hit& hit) {
    const double height = half[1];
    // Radius at y: middle + slope y.
    const double slope = (half[2] - half[0]) / (2 * height);
    const double middle = (half[2] + half[0]) / 2;
    const double ro = middle + slope * o[1];
    const double rd = slope * d[1];
    const double a = d[0] * d[0] + d[2] * d[2] - rd * rd;
    const double b = o[0] * d[0] + o[2] * d[2] - ro * rd;
    const double c = o[0] * o[0] + o[2] * o[2] - ro * ro;
    double start = from;
    for (int attempt = 0; attempt < 2; ++attempt) { // the first root may lie beyond an end
        const double t = firstRoot(a, b, c, start);
        if (t >= hit.distance) break;
        const Vec place = o + d * t;
        if (std::abs(place[1]) <= height && middle + slope * place[1] >= 0) {
            hit.distance = t;
            hit.local = place;
            hit.normal = normalized(Vec(place[0], -slope * (middle + slope * place[1]), place[2]));
            break;
        }
        start = t;
    }
    if (d[1] == 0) return;
    for (const double end : {-height, height}) {
        const double t = (end - o[1]) / d[1];
        if (t <= from || t >= hit.distance) continue;
        const Vec place = o + d * t;
        const double radius = end < 0 ? half[0] : half[2];
        if (place[0] * place[0] + place[2] * place[2] > radius * radius) continue;
        hit.distance = t;
        hit.local = place;
        hit.normal = Vec(0, end < 0 ? -1 : 1, 0);
    }
}

void hitSolid(const Prepared& prepared, const Ray& ray, double from, Hit& hit) {
    const Solid& solid = *prepared.solid;
    Vec o = ray.origin - solid.centre;
    Vec d = ray.direction;
    if (solid.form == Form::Plane) {
        const double t = -o[1] / d[1];
        if (!(t > from) || t >= hit.distance) return;
        hit.distance = t;
        hit.local = o + d * t;
        hit.normal = Vec(0, o[1] > 0 ? 1 : -1, 0);
        hit.solid = &solid;
        return;
    }
    // Whether the ray misses the sphere about the solid.
    const double along = o.dot(d);
    const double length = d.dot(d);
    const double outside = o.dot(o) - prepared.boundRadius * prepared.boundRadius;
    if (outside > 0) {
        if (along > 0 || along * along < outside * length) return;
        const double toSphere = -along - prepared.boundRadius * std::sqrt(length);
        if (toSphere > hit.distance * length) return; // something nearer was found
    }

    const double before = hit.distance;
    switch (solid.form) {
    case Form::Ellipsoid:
        hitEllipsoid(o, d, solid.half, from, hit);
        break;
    case Form::Box:
        o = turned(o, prepared.cosYaw, prepared.sinYaw);
        d = turned(d, prepared.cosYaw, prepared.sinYaw);
        hitBox(o, d, solid.half, from, hit);
        break;
    case Form::Frustum:
        hitFrustum(o, d, solid.half, from, hit);
        break;
    case Form::Plane:
        break;
    }
    if (hit.distance >= before) return;
    hit.solid = &solid;
    if (solid.form == Form::Box) hit.normal = turned(hit.normal, prepared.cosYaw, -prepared.sinYaw);
}

// --- Looks -----------------------------------------------------------------------------------

struct Surface {
    Vec colour;
    Vec normal;
    double gloss = 0;
};

// The two coordinates of a place on its face: the floor's for horizontal faces, else along the wall
// and up. Round solids unroll.
cv::Vec2d faceCoordinates(const Hit& hit) {
    const Vec& p = hit.local;
    if (hit.solid->form == Form::Box) {
        const Vec& half = hit.solid->half;
        if (std::abs(std::abs(p[1]) - half[1]) < 1e-9) return {p[0], p[2]};
        return std::abs(std::abs(p[0]) - half[0]) < 1e-9 ? cv::Vec2d(p[2], p[1])
                                                         : cv::Vec2d(p[0], p[1]);
    }
    if (std::abs(hit.normal[1]) > 0.999 || hit.solid->form == Form::Plane) return {p[0], p[2]};
    return {std::atan2(p[0], p[2]) * std::max(hit.solid->half[0], hit.solid->half[2]), p[1]};
}

// Noise in place of the normal's direction, for leaves and water.
Vec rippled(const Vec& normal, const Vec& at, double strength) {
    const Vec ripple(noise(at) - 0.5, noise(at + Vec(31.4, 0, 0)) - 0.5,
                     noise(at + Vec(0, 0, 57.1)) - 0.5);
    return normalized(normal + ripple * (2 * strength));
}

Surface surfaceAt(const Hit& hit, const Vec& place) {
    const Material& material = hit.solid->material;
    Surface surface{material.first, hit.normal, material.gloss};
    const Vec& p = hit.local;
    switch (material.pattern) {
    case Pattern::Plain:
        break;
    case Pattern::Tiles: { // a joint around each tile, and no two tiles quite alike
        const cv::Vec2d uv = faceCoordinates(hit) / material.size;
        const double column = std::floor(uv[0]);
        const double row = std::floor(uv[1]);
        const double x = uv[0] - column;
        const double y = uv[1] - row;
        const double edge = std::min({x, 1 - x, y, 1 - y});
        const auto i = static_cast<std::int64_t>(column);
        const auto j = static_cast<std::int64_t>(row);
        const Vec tile = ((i + j) & 1) == 0 ? material.first : material.second;
        const double shade = 0.82 + 0.2 * hash(i, j, 7) + 0.22 * (cloudNoise(place * 9, 4) - 0.5);
        const double joint = smoothStep(0.012, 0.022, edge);
        surface.colour = mix(Vec(0.30, 0.27, 0.23), tile * shade, joint);
        surface.gloss = material.gloss * joint;
        break;
    }
    case Pattern::Checker: {
        const cv::Vec2d uv = faceCoordinates(hit) / material.size;
        const double both = std::floor(uv[0]) + std::floor(uv[1]);
        if (std::fmod(std::abs(both), 2.0) >= 1) surface.colour = material.second;
        break;
    }
    case Pattern::Stripes: { // meridians about a tilted axis, `size` of them
        const double angle = std::atan2(p[0] * 0.9 - p[1] * 0.45, p[2]);
        const double part = angle / (2 * kPi) * material.size;
        if (part - std::floor(part) >= 0.5) surface.colour = material.second;
        break;
    }
    case Pattern::Wood: { // long fibres along the longest side
        const Vec& half = hit.solid->half;
        int axis = 0;
        for (int i = 1; i < 3; ++i)
            if (half[i] > half[axis]) axis = i;
        Vec at = p / material.size + hit.solid->centre * 3.7;
        at[axis] *= 0.08;
        const double rings = cloudNoise(at * 2, 3) * 7;
        const double fibre = cloudNoise(at * 14, 2);
        const double t = std::abs(std::fmod(rings, 1.0) * 2 - 1);
        surface.colour = mix(material.first, material.second, 0.65 * t + 0.35 * fibre);
        break;
    }
    case Pattern::Marble: {
        const Vec at = place / material.size;
        const double vein = std::abs(2 * cloudNoise(at, 5) - 1);
        surface.colour = mix(material.second, material.first, smoothStep(0.0, 0.16, vein));
        surface.colour *= 0.93 + 0.14 * cloudNoise(at * 3, 3);
        break;
    }
    case Pattern::Leaves: {
        const Vec at = place / material.size;
        const double leaf = noise(at * 2.2);
        surface.colour = mix(material.second, material.first,
                             smoothStep(0.25, 0.75, 0.7 * leaf + 0.3 * noise(at * 5)));
        surface.normal = rippled(hit.normal, at * 2.2, 0.8);
        break;
    }
    case Pattern::Water: { // calmer to the eye the farther it is
        const double distance = cv::norm(place);
        const double calm = 1 / (1 + distance / 60);
        const double swell = cloudNoise(Vec(place[0] * 0.05, 0, place[2] * 0.02), 4);
        surface.colour = mix(material.first, material.second, smoothStep(0.35, 0.65, swell));
        surface.normal = rippled(
            hit.normal, Vec(place[0] / material.size, 0, place[2] / material.size), 0.16 * calm);
        break;
    }
    case Pattern::Plaster:
        surface.colour = mix(material.second, material.first, cloudNoise(place / material.size, 5));
        break;
    }
    return surface;
}

Vec skyColour(const Vec& direction, const Vec& toLight) {
    const Vec d = normalized(direction);
    const double up = std::max(d[1], 0.0);
    Vec colour = mix(Vec(0.80, 0.86, 0.92), Vec(0.04, 0.25, 0.60), std::pow(up, 0.5) * 1.2);
    // Clouds on a flat layer, thinning out towards the horizon.
    if (d[1] > 0.01) {
        const Vec at(d[0] / (d[1] + 0.12) * 1.6, 0.5, d[2] / (d[1] + 0.12) * 1.1);
        const double cover = smoothStep(0.50, 0.74, cloudNoise(at + Vec(4.6, 0, 2.2), 6));
        colour = mix(colour, Vec(0.97, 0.97, 0.98), cover * smoothStep(0.01, 0.16, d[1]) * 0.9);
    }
    const double sun = std::max(d.dot(toLight), 0.0);
    return colour + Vec(0.30, 0.24, 0.14) * std::pow(sun, 24);
}

class Renderer {
  public:
    explicit Renderer(const Scene& scene) : scene_(scene), toLight_(normalized(scene.toLight)) {
        for (const Solid& solid : scene.solids)
            solids_.push_back(prepare(solid));
    }

    Hit nearest(const Ray& ray, double from) const {
        Hit hit;
        for (const Prepared& solid : solids_)
            hitSolid(solid, ray, from, hit);
        return hit;
    }

    // Linear RGB of a ray. `seed` picks the positions on the sun's disc and in the hemisphere.
    Vec colourOf(const Ray& ray, std::int64_t seed, int bounces) const {
        const Hit hit = nearest(ray, kEpsilon);
        if (hit.solid == nullptr) return skyColour(ray.direction, toLight_);
        const Vec place = ray.origin + ray.direction * hit.distance;
        const Vec view = normalized(ray.direction);
        const Surface surface = surfaceAt(hit, place);
        const Vec start = place + hit.normal * (10 * kEpsilon);

        const double facing = surface.normal.dot(toLight_);
        double sun = 0;
        if (facing > 0 && hit.normal.dot(toLight_) > -0.3) {
            const Vec blur(hash(seed, 1, 0) - 0.5, hash(seed, 2, 0) - 0.5, hash(seed, 3, 0) - 0.5);
            sun = blocked({start, toLight_ + blur * 0.035}, kInfinity) ? 0 : facing;
        }
        const double open = openness(start, surface.normal, seed);
        const Vec ambient =
            mix(Vec(0.17, 0.14, 0.11), Vec(0.24, 0.31, 0.43), 0.5 + 0.5 * surface.normal[1]) * open;
        Vec colour = multiply(surface.colour, ambient + Vec(1.55, 1.36, 1.06) * sun);

        if (surface.gloss > 0) {
            const double cosine = std::clamp(-view.dot(surface.normal), 0.0, 1.0);
            const double fresnel =
                surface.gloss + (1 - surface.gloss) * std::pow(1 - cosine, 5) * 0.8;
            const Vec mirrored = view - surface.normal * (2 * view.dot(surface.normal));
            // A mirror of metal tints what it shows, a varnish does not.
            const Vec tint = mix(Vec(1, 1, 1), surface.colour, surface.gloss > 0.4 ? 0.85 : 0.0);
            if (bounces > 0) {
                const Vec shown = colourOf({start, mirrored}, seed * 31 + 5, bounces - 1);
                colour = mix(colour, multiply(tint, shown), fresnel);
            }
            const double glint = std::pow(std::max(mirrored.dot(toLight_), 0.0), 220);
            colour += tint * (sun > 0 ? 2.5 * glint * std::sqrt(surface.gloss) : 0.0);
        }
        if (scene_.hazeDistance > 0) {
            const double clear = std::exp(-cv::norm(place - ray.origin) / scene_.hazeDistance);
            colour = mix(Vec(0.66, 0.76, 0.88), colour, clear);
        }
        return colour;
    }

  private:
    bool blocked(const Ray& ray, double limit) const {
        Hit hit;
        hit.distance = limit;
        return std::any_of(solids_.begin(), solids_.end(), [&](const Prepared& solid) {
            hitSolid(solid, ray, kEpsilon, hit);
            return hit.solid != nullptr;
        });
    }

    // The part of the hemisphere that is free nearby, 0..1.
    double openness(const Vec& place, const Vec& normal, std::int64_t seed) const {
        constexpr int kRays = 4;
        constexpr double kReach = 0.9; // m
        double open = 0;
        for (int i = 0; i < kRays; ++i) {
            const double turn = 2 * kPi * ((i + hash(seed, i, 11)) / kRays);
            const double height = 1 - 2 * hash(seed, i, 12);
            const double radius = std::sqrt(std::max(0.0, 1 - height * height));
            // A point of the unit sphere on top of the normal: cosine distribution.
            const Vec direction =
                normal * 1.001 + Vec(radius * std::cos(turn), height, radius * std::sin(turn));
            const Vec unit = normalized(direction);
            if (!blocked({place, unit}, kReach)) open += 1;
        }
        return 0.25 + 0.75 * open / kRays;
    }

    const Scene& scene_;
    Vec toLight_;
    std::vector<Prepared> solids_;
};

// Linear light to 8 bits: a soft shoulder for what is brighter than white, then the sRGB curve.
uchar toByte(double linear) {
    const double x = std::max(0.0, linear * 0.86);
    const double soft = x < 0.6 ? x : 0.6 + 0.4 * (1 - std::exp(-(x - 0.6) / 0.4));
    const double curve = soft <= 0.0031308 ? 12.92 * soft : 1.055 * std::pow(soft, 1 / 2.4) - 0.055;
    return cv::saturate_cast<uchar>(curve * 255);
}

// The ray through a point of the picture (in px, see project()); one unit along it is 1 m of z.
Ray rayThrough(const Scene& scene, cv::Size size, double cameraX, double x, double y) {
    const double focal = scene.focalWidths * size.width;
    const double shift = cameraX / scene.focusDistance;
    return {Vec(cameraX, scene.cameraHeight, 0), Vec((x - size.width / 2.0) / focal - shift,
                                                     (scene.horizon * size.height - y) / focal, 1)};
}

} // namespace

Solid sphere(const Vec& centre, double radius, const Material& material) {
    return {Form::Ellipsoid, centre, Vec(radius, radius, radius), 0, material};
}

Solid ellipsoid(const Vec& centre, const Vec& halfAxes, const Material& material) {
    return {Form::Ellipsoid, centre, halfAxes, 0, material};
}

Solid box(const Vec& centre, const Vec& halfSides, double yawDegrees, const Material& material) {
    return {Form::Box, centre, halfSides, yawDegrees, material};
}

Solid frustum(const Vec& foot, double height, double lowerRadius, double upperRadius,
              const Material& material) {
    return {Form::Frustum, foot + Vec(0, height / 2, 0), Vec(lowerRadius, height / 2, upperRadius),
            0, material};
}

Solid plane(double height, const Material& material) {
    return {Form::Plane, Vec(0, height, 0), Vec(0, 0, 0), 0, material};
}

cv::Point2d project(const Scene& scene, cv::Size size, double cameraX, const Vec& point) {
    const double focal = scene.focalWidths * size.width;
    return {size.width / 2.0 +
                focal * ((point[0] - cameraX) / point[2] + cameraX / scene.focusDistance),
            scene.horizon * size.height - focal * (point[1] - scene.cameraHeight) / point[2]};
}

double relativeInverseDepth(const Scene& scene, double z) {
    const double low = 1 / scene.farDistance;
    return std::clamp((1 / z - low) / (1 / scene.nearDistance - low), 0.0, 1.0);
}

Rendering render(const Scene& scene, cv::Size size, double cameraX, int samplesPerPixel) {
    const Renderer renderer(scene);
    int grid = 1; // samples on a side
    while (grid * grid < samplesPerPixel)
        ++grid;
    Rendering result{cv::Mat(size, CV_8UC3), cv::Mat(size, CV_32FC1), cv::Mat(size, CV_32FC1)};
    cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            for (int x = 0; x < size.width; ++x) {
                const Ray centre = rayThrough(scene, size, cameraX, x + 0.5, y + 0.5);
                const double z = renderer.nearest(centre, 0).distance;
                result.metric.at<float>(y, x) = static_cast<float>(z);
                result.depth.at<float>(y, x) = static_cast<float>(relativeInverseDepth(scene, z));
                Vec sum(0, 0, 0);
                for (int i = 0; i < grid * grid; ++i) {
                    const int column = i % grid;
                    const int row = i / grid;
                    const Ray ray = rayThrough(scene, size, cameraX, x + (column + 0.5) / grid,
                                               y + (row + 0.5) / grid);
                    const std::int64_t pixel = static_cast<std::int64_t>(y) * size.width + x;
                    const Vec colour = renderer.colourOf(ray, pixel * grid * grid + i, 2);
                    for (int c = 0; c < 3; ++c) // a single highlight must not dominate its pixel
                        sum[c] += std::min(colour[c], 3.0);
                }
                sum *= 1.0 / (grid * grid);
                result.photo.at<cv::Vec3b>(y, x) =
                    cv::Vec3b(toByte(sum[2]), toByte(sum[1]), toByte(sum[0]));
            }
        }
    });
    return result;
}

struct RayCaster::Impl {
    explicit Impl(const Scene& world) : scene(world), renderer(scene) {}

    // Mean of grid x grid rays. Every block of 2 x 2 samples light in the same four ways.
    Vec mean(cv::Size size, double cameraX, const cv::Rect2d& part, int grid, int& contrast) const {
        Vec sum(0, 0, 0);
        cv::Vec3i low(255, 255, 255);
        cv::Vec3i high(0, 0, 0);
        for (int row = 0; row < grid; ++row) {
            for (int column = 0; column < grid; ++column) {
                const Ray ray =
                    rayThrough(scene, size, cameraX, part.x + (column + 0.5) / grid * part.width,
                               part.y + (row + 0.5) / grid * part.height);
                const Vec colour = renderer.colourOf(ray, column % 2 + 2 * (row % 2), 2);
                for (int c = 0; c < 3; ++c) {
                    sum[c] += std::min(colour[c], 3.0);
                    low[c] = std::min<int>(low[c], toByte(colour[c]));
                    high[c] = std::max<int>(high[c], toByte(colour[c]));
                }
            }
        }
        contrast = std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]});
        return sum * (1.0 / (grid * grid));
    }

    Scene scene;
    Renderer renderer; // of `scene`
};

RayCaster::RayCaster(const Scene& scene) : impl_(std::make_shared<const Impl>(scene)) {}

cv::Vec3b RayCaster::colour(cv::Size size, double cameraX, const cv::Rect2d& part) const {
    constexpr int kVisible = 10; // grey levels
    int contrast = 0;
    Vec found = impl_->mean(size, cameraX, part, 2, contrast);
    if (contrast > kVisible) found = impl_->mean(size, cameraX, part, 4, contrast);
    return {toByte(found[2]), toByte(found[1]), toByte(found[0])};
}

double RayCaster::depth(cv::Size size, double cameraX, const cv::Point2d& at) const {
    const Ray ray = rayThrough(impl_->scene, size, cameraX, at.x, at.y);
    return relativeInverseDepth(impl_->scene, impl_->renderer.nearest(ray, 0).distance);
}

Scene sampleScene() {
    Scene scene;
    scene.toLight = Vec(-0.62, 0.72, -0.42);
    scene.cameraHeight = 1.35;
    scene.focalWidths = 1.25;
    scene.horizon = 0.40;
    scene.focusDistance = 4.2;
    scene.nearDistance = 2.0;
    scene.farDistance = 400;
    scene.hazeDistance = 620;

    const Material tiles{Pattern::Tiles, {0.70, 0.58, 0.42}, {0.52, 0.24, 0.13}, 0.42, 0.035};
    const Material stone{Pattern::Plaster, {0.86, 0.82, 0.74}, {0.66, 0.61, 0.52}, 0.25, 0};
    const Material marble{Pattern::Marble, {0.88, 0.86, 0.83}, {0.45, 0.44, 0.46}, 0.45, 0.04};
    const Material darkMarble{Pattern::Marble, {0.10, 0.22, 0.19}, {0.55, 0.62, 0.55}, 0.3, 0.06};
    const Material beam{Pattern::Wood, {0.50, 0.30, 0.15}, {0.30, 0.16, 0.07}, 0.25, 0};
    const Material crate{Pattern::Wood, {0.72, 0.48, 0.25}, {0.46, 0.27, 0.11}, 0.16, 0};
    const Material clay{Pattern::Plaster, {0.70, 0.30, 0.16}, {0.52, 0.20, 0.10}, 0.12, 0};
    const Material soil{Pattern::Plaster, {0.10, 0.06, 0.04}, {0.05, 0.03, 0.02}, 0.03, 0};
    const Material leaves{Pattern::Leaves, {0.24, 0.42, 0.07}, {0.02, 0.08, 0.015}, 0.032, 0};
    const Material cypress{Pattern::Leaves, {0.10, 0.22, 0.07}, {0.02, 0.07, 0.03}, 0.22, 0};
    const Material hill{Pattern::Leaves, {0.17, 0.25, 0.08}, {0.06, 0.12, 0.04}, 6, 0};
    const Material sea{Pattern::Water, {0.015, 0.13, 0.26}, {0.03, 0.24, 0.36}, 1.6, 0.03};
    const Material gold{Pattern::Plain, {1.00, 0.72, 0.30}, {}, 1, 0.75};
    const Material red{Pattern::Plain, {0.62, 0.02, 0.03}, {}, 1, 0.06};
    const Material lemon{Pattern::Plaster, {0.90, 0.66, 0.04}, {0.80, 0.52, 0.02}, 0.03, 0.03};
    const Material ball{Pattern::Stripes, {0.86, 0.86, 0.84}, {0.02, 0.16, 0.50}, 6, 0.05};
    const Material dice{Pattern::Checker, {0.85, 0.83, 0.78}, {0.03, 0.30, 0.30}, 0.07, 0.04};

    std::vector<Solid>& solids = scene.solids;
    const auto add = [&](const Solid& solid) { solids.push_back(solid); };

    // The terrace, and the sea below it up to the horizon.
    add(box({0, -0.5, 4.6}, {14, 0.5, 5.3}, 0, tiles));
    add(plane(-14, sea));
    add(ellipsoid({-122, -16, 250}, {95, 46, 40}, hill));
    add(ellipsoid({135, -16, 330}, {110, 42, 40}, hill));
    add(ellipsoid({-75, -16, 190}, {46, 27, 20}, hill));
    add(ellipsoid({112, -16, 230}, {60, 46, 30}, hill));

    // A pergola: columns with foot and head, beams along and across.
    for (const double x : {-1.72, 1.72}) {
        for (const double z : {4.9, 7.0, 9.1}) {
            add(box({x, 0.11, z}, {0.24, 0.11, 0.24}, 0, stone));
            add(frustum({x, 0.22, z}, 0.06, 0.21, 0.18, marble));
            add(frustum({x, 0.28, z}, 2.34, 0.165, 0.14, marble));
            add(frustum({x, 2.62, z}, 0.10, 0.14, 0.22, marble));
            add(box({x, 2.77, z}, {0.24, 0.05, 0.24}, 0, stone));
        }
        add(box({x, 2.91, 6.8}, {0.08, 0.09, 2.7}, 0, beam));
    }
    for (int i = 0; i < 7; ++i)
        add(box({0, 3.07, 4.5 + 0.8 * i}, {2.25, 0.07, 0.05}, 0, beam));

    // The balustrade at the far edge.
    add(box({0, 0.06, 9.65}, {7, 0.06, 0.16}, 0, stone));
    add(box({0, 0.91, 9.65}, {7, 0.06, 0.17}, 0, stone));
    for (int i = -13; i <= 13; ++i) {
        const double x = 0.33 * i;
        add(ellipsoid({x, 0.40, 9.65}, {0.10, 0.30, 0.10}, stone));
        add(frustum({x, 0.55, 9.65}, 0.30, 0.035, 0.075, stone));
    }
    // Cypresses behind it.
    add(ellipsoid({-2.9, 0.4, 14.0}, {0.62, 3.0, 0.62}, cypress));
    add(ellipsoid({-4.0, 0.2, 17.5}, {0.75, 3.6, 0.75}, cypress));
    add(ellipsoid({3.3, -0.4, 13.0}, {0.55, 2.6, 0.55}, cypress));

    // A golden ball on a pedestal.
    add(box({0.22, 0.05, 6.2}, {0.36, 0.05, 0.36}, 0, darkMarble));
    add(box({0.22, 0.45, 6.2}, {0.26, 0.35, 0.26}, 0, darkMarble));
    add(box({0.22, 0.83, 6.2}, {0.33, 0.03, 0.33}, 0, darkMarble));
    add(sphere({0.22, 1.22, 6.2}, 0.36, gold));

    // A clipped tree in a pot.
    add(frustum({-0.78, 0, 3.75}, 0.40, 0.19, 0.27, clay));
    add(frustum({-0.78, 0.40, 3.75}, 0.07, 0.30, 0.30, clay));
    add(frustum({-0.78, 0.46, 3.75}, 0.02, 0.26, 0.26, soil));
    add(frustum({-0.78, 0.46, 3.75}, 0.50, 0.028, 0.022, beam));
    add(sphere({-0.78, 1.17, 3.75}, 0.36, leaves));

    // Crates with a red ball, and toys on the floor.
    add(box({0.80, 0.24, 3.75}, {0.30, 0.24, 0.30}, 24, crate));
    add(box({0.80, 0.24, 3.75}, {0.305, 0.03, 0.305}, 24, beam));
    add(box({0.86, 0.61, 3.80}, {0.20, 0.13, 0.20}, -12, crate));
    add(sphere({0.86, 0.91, 3.80}, 0.17, red));
    add(sphere({0.02, 0.22, 3.35}, 0.22, ball));
    add(box({0.47, 0.105, 2.85}, {0.105, 0.105, 0.105}, -32, dice));
    add(sphere({-0.44, 0.075, 2.60}, 0.075, lemon));
    add(ellipsoid({-0.26, 0.07, 2.75}, {0.09, 0.07, 0.07}, lemon));
    return scene;
}

} // namespace altiro3D::test
