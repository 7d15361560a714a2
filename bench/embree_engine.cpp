// Embree's rtcCollide behind a C interface, for embree_engine.py.
//
// Embree walks two trees of user geometries and calls back with pairs of triangles whose boxes may meet; whether the
// triangles meet is the caller's business. Here that is Möller's test of 1997 (no divisions), in float as all of Embree.
// The mock-up is a static scene. The tool is a dynamic scene, whose corners are moved and whose tree is refitted at
// every pose: rtcCollide takes no pose and no instances.
#include <embree3/rtcore.h>

#include <cmath>
#include <cstdint>
#include <vector>

namespace {

struct Vec {
    float x, y, z;
};

inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline float smaller(float a, float b) { return a < b ? a : b; }
inline float larger(float a, float b) { return a > b ? a : b; }

// Corners side by side; reading them by index took the same time.
struct Triangle {
    Vec a, b, c;
};


// --- triangles of one plane, seen along the axis on which it stands steepest ---------------------------------------

struct Flat {
    float u, v;
};

inline float turn(Flat a, Flat b, Flat c) { return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u); }

bool coplanar(Vec normal, const Triangle &p, const Triangle &q) {
    const float x = std::fabs(normal.x), y = std::fabs(normal.y), z = std::fabs(normal.z);
    auto flat = [&](Vec v) -> Flat {
        if (x >= y && x >= z) return {v.y, v.z};
        if (y >= z) return {v.z, v.x};
        return {v.x, v.y};
    };
    const Flat one[3] = {flat(p.a), flat(p.b), flat(p.c)}, two[3] = {flat(q.a), flat(q.b), flat(q.c)};
    // Apart if and only if a side of one has the other's corners all beyond it.
    auto side_parts = [](const Flat *of, const Flat *other) {
        const float hand = turn(of[0], of[1], of[2]);
        for (int i = 0, j = 2; i < 3; j = i++) {
            bool beyond = true;
            for (int k = 0; k < 3; k++) beyond &= turn(of[j], of[i], other[k]) * hand < 0;
            if (beyond) return true;
        }
        return false;
    };
    return !side_parts(one, two) && !side_parts(two, one);
}

// --- Möller 1997 ----------------------------------------------------------------------------------------------------

// Where the line of both planes passes the triangle, p along it, d over the other plane: `alone` is on one side.
inline void span(float p_alone, float p1, float p2, float d_alone, float d1, float d2, float &a, float &b, float &c,
                 float &x0, float &x1) {
    a = p_alone;
    b = (p1 - p_alone) * d_alone;
    c = (p2 - p_alone) * d_alone;
    x0 = d_alone - d1;
    x1 = d_alone - d2;
}

// False where all three lie in the plane.
inline bool interval(float p0, float p1, float p2, float d0, float d1, float d2, float &a, float &b, float &c,
                     float &x0, float &x1) {
    if (d0 * d1 > 0)
        span(p2, p0, p1, d2, d0, d1, a, b, c, x0, x1);
    else if (d0 * d2 > 0)
        span(p1, p0, p2, d1, d0, d2, a, b, c, x0, x1);
    else if (d1 * d2 > 0 || d0 != 0)
        span(p0, p1, p2, d0, d1, d2, a, b, c, x0, x1);
    else if (d1 != 0)
        span(p1, p0, p2, d1, d0, d2, a, b, c, x0, x1);
    else if (d2 != 0)
        span(p2, p0, p1, d2, d0, d1, a, b, c, x0, x1);
    else
        return false;
    return true;
}

inline bool meets(const Triangle &p, const Triangle &q) {
    const Vec n1 = cross(p.b - p.a, p.c - p.a);
    const float e0 = dot(n1, q.a - p.a), e1 = dot(n1, q.b - p.a), e2 = dot(n1, q.c - p.a);
    if ((e0 > 0 && e1 > 0 && e2 > 0) || (e0 < 0 && e1 < 0 && e2 < 0)) return false;
    const Vec n2 = cross(q.b - q.a, q.c - q.a);
    const float d0 = dot(n2, p.a - q.a), d1 = dot(n2, p.b - q.a), d2 = dot(n2, p.c - q.a);
    if ((d0 > 0 && d1 > 0 && d2 > 0) || (d0 < 0 && d1 < 0 && d2 < 0)) return false;

    const Vec along = cross(n1, n2);
    const float x = std::fabs(along.x), y = std::fabs(along.y), z = std::fabs(along.z);
    const float Vec::*axis = x >= y && x >= z ? &Vec::x : y >= z ? &Vec::y : &Vec::z;
    float a, b, c, x0, x1, d, e, f, y0, y1;
    if (!interval(p.a.*axis, p.b.*axis, p.c.*axis, d0, d1, d2, a, b, c, x0, x1)) return coplanar(n1, p, q);
    if (!interval(q.a.*axis, q.b.*axis, q.c.*axis, e0, e1, e2, d, e, f, y0, y1)) return coplanar(n1, p, q);
    const float xx = x0 * x1, yy = y0 * y1, xxyy = xx * yy;
    const float base1 = a * xxyy, base2 = d * xxyy;
    const float s0 = base1 + b * x1 * yy, s1 = base1 + c * x0 * yy;
    const float t0 = base2 + e * xx * y1, t1 = base2 + f * xx * y0;
    return larger(s0, s1) >= smaller(t0, t1) && larger(t0, t1) >= smaller(s0, s1);
}

// --- scenes -----------------------------------------------------------------------------------------------------------

void bounds(const RTCBoundsFunctionArguments *args) {
    const Triangle &t = static_cast<const Triangle *>(args->geometryUserPtr)[args->primID];
    RTCBounds &box = *args->bounds_o;
    box.lower_x = smaller(smaller(t.a.x, t.b.x), t.c.x);
    box.lower_y = smaller(smaller(t.a.y, t.b.y), t.c.y);
    box.lower_z = smaller(smaller(t.a.z, t.b.z), t.c.z);
    box.upper_x = larger(larger(t.a.x, t.b.x), t.c.x);
    box.upper_y = larger(larger(t.a.y, t.b.y), t.c.y);
    box.upper_z = larger(larger(t.a.z, t.b.z), t.c.z);
}

struct Body {
    RTCScene scene = nullptr;
    RTCGeometry geometry = nullptr;
    std::vector<Vec> vertices;
    std::vector<uint32_t> faces;
    std::vector<Triangle> triangles;

    void gather(const Vec *from) {
        const uint32_t *face = faces.data();
        for (Triangle &t : triangles) {
            t = {from[face[0]], from[face[1]], from[face[2]]};
            face += 3;
        }
    }

    void make(RTCDevice device, const double *xyz, size_t corners, const uint32_t *abc, size_t count,
              RTCSceneFlags flags, RTCBuildQuality scene_quality, RTCBuildQuality quality) {
        vertices.resize(corners);
        for (size_t i = 0; i < corners; i++)
            vertices[i] = {float(xyz[3 * i]), float(xyz[3 * i + 1]), float(xyz[3 * i + 2])};
        faces.assign(abc, abc + 3 * count);
        triangles.resize(count);
        gather(vertices.data());
        geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryBuildQuality(geometry, quality);
        rtcSetGeometryUserPrimitiveCount(geometry, unsigned(count));
        rtcSetGeometryUserData(geometry, triangles.data());
        rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
        rtcCommitGeometry(geometry);
        scene = rtcNewScene(device);
        rtcSetSceneFlags(scene, flags);
        rtcSetSceneBuildQuality(scene, scene_quality);
        rtcAttachGeometry(scene, geometry);
        rtcCommitScene(scene);
    }

    void drop() {
        if (scene) rtcReleaseScene(scene);
        if (geometry) rtcReleaseGeometry(geometry);
        scene = nullptr;
        geometry = nullptr;
    }
};

struct Engine {
    RTCDevice device = nullptr;
    Body mockup, tool;
    std::vector<Vec> moved;
    std::vector<uint32_t> pairs; // tool triangle, mock-up triangle
    int64_t bytes = 0;           // what Embree holds, as it reports itself
    bool found = false;

    void place(const double *m) {
        float r[12];
        for (int i = 0; i < 12; i++) r[i] = float(m[i]);
        Vec *out = moved.data();
        for (const Vec &v : tool.vertices)
            *out++ = {r[0] * v.x + r[1] * v.y + r[2] * v.z + r[3], r[4] * v.x + r[5] * v.y + r[6] * v.z + r[7],
                      r[8] * v.x + r[9] * v.y + r[10] * v.z + r[11]};
        tool.gather(moved.data());
        rtcCommitGeometry(tool.geometry);
        rtcCommitScene(tool.scene);
    }
};

bool count_bytes(void *engine, ssize_t bytes, bool) {
    __atomic_add_fetch(&static_cast<Engine *>(engine)->bytes, bytes, __ATOMIC_RELAXED);
    return true;
}

void every_pair(void *user, RTCCollision *hits, unsigned count) {
    Engine &engine = *static_cast<Engine *>(user);
    const Triangle *tool = engine.tool.triangles.data(), *mockup = engine.mockup.triangles.data();
    for (unsigned i = 0; i < count; i++) {
        if (meets(tool[hits[i].primID0], mockup[hits[i].primID1])) {
            engine.pairs.push_back(hits[i].primID0);
            engine.pairs.push_back(hits[i].primID1);
        }
    }
}

// rtcCollide cannot be stopped: after the first contact the walk goes on, and each callback returns at once.
void any_pair(void *user, RTCCollision *hits, unsigned count) {
    Engine &engine = *static_cast<Engine *>(user);
    if (engine.found) return;
    const Triangle *tool = engine.tool.triangles.data(), *mockup = engine.mockup.triangles.data();
    for (unsigned i = 0; i < count && !engine.found; i++)
        engine.found = meets(tool[hits[i].primID0], mockup[hits[i].primID1]);
}

} // namespace

extern "C" {

Engine *embree_new(const char *config, int quality, const double *vertices, size_t corners, const uint32_t *faces,
                   size_t count) {
    Engine *engine = new Engine;
    engine->device = rtcNewDevice(config);
    if (!engine->device) {
        delete engine;
        return nullptr;
    }
    rtcSetDeviceMemoryMonitorFunction(engine->device, count_bytes, engine);
    engine->mockup.make(engine->device, vertices, corners, faces, count, RTC_SCENE_FLAG_NONE,
                        RTCBuildQuality(quality), RTCBuildQuality(quality));
    // The callback reads gathered corners: the indexed copy has served.
    engine->mockup.vertices = {};
    engine->mockup.faces = {};
    return engine;
}

void embree_free(Engine *engine) {
    if (!engine) return;
    engine->tool.drop();
    engine->mockup.drop();
    rtcReleaseDevice(engine->device);
    delete engine;
}

void embree_tool(Engine *engine, const double *vertices, size_t corners, const uint32_t *faces, size_t count) {
    engine->tool.drop();
    engine->tool.make(engine->device, vertices, corners, faces, count, RTC_SCENE_FLAG_DYNAMIC,
                      RTC_BUILD_QUALITY_LOW, RTC_BUILD_QUALITY_REFIT);
    engine->moved.resize(corners);
}

size_t embree_collide(Engine *engine, const double *world_from_tool) {
    engine->place(world_from_tool);
    engine->pairs.clear();
    rtcCollide(engine->tool.scene, engine->mockup.scene, every_pair, engine);
    return engine->pairs.size() / 2;
}

int embree_is_colliding(Engine *engine, const double *world_from_tool) {
    engine->place(world_from_tool);
    engine->found = false;
    rtcCollide(engine->tool.scene, engine->mockup.scene, any_pair, engine);
    return engine->found;
}

const uint32_t *embree_pairs(const Engine *engine) { return engine->pairs.data(); }

// What Embree counts of its own, and the corners that the callback needs.
int64_t embree_bytes(const Engine *engine) {
    return engine->bytes + int64_t(engine->mockup.triangles.capacity() * sizeof(Triangle));
}

void embree_version(int *three) {
    RTCDevice device = rtcNewDevice("threads=1");
    three[0] = int(rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MAJOR));
    three[1] = int(rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_MINOR));
    three[2] = int(rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_VERSION_PATCH));
    rtcReleaseDevice(device);
}
}
