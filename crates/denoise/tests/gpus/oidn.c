// A library with the interface of Open Image Denoise that pretends to have GPUs: what they do is known, and they fail when
// they are told to. The first byte of a GPU's UUID says what it is like.
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>

enum { COPIES_COLOR = 1, COPIES_ALBEDO, COPIES_NORMAL, RUNS_OUT_OF_MEMORY, REFUSES_MEMORY, TAKES_NO_MEMORY, LAST };

typedef struct { int kind; const char *error; } Device;
typedef struct { Device *device; char *data; size_t size; } Buffer;
typedef struct { char *data; size_t pixel; size_t width, height; } Image;
typedef struct { Device *device; Image color, albedo, normal, output; } Filter;

static const char *lost_error;

Device *oidnNewDevice(int type)
{
    Device *device = calloc(1, sizeof(Device));
    device->kind = type == 1 ? 0 : COPIES_COLOR;
    return device;
}

Device *oidnNewDeviceByUUID(const unsigned char *uuid)
{
    if (uuid[0] < COPIES_COLOR || uuid[0] >= LAST) {
        lost_error = "no physical device found with specified UUID";
        return NULL;
    }
    Device *device = calloc(1, sizeof(Device));
    device->kind = uuid[0];
    return device;
}

Device *oidnNewDeviceByLUID(const void *luid) { return (void)luid, NULL; }
void oidnCommitDevice(Device *device) { (void)device; }
void oidnReleaseDevice(Device *device) { free(device); }

int oidnGetDeviceError(Device *device, const char **message)
{
    const char **error = device ? &device->error : &lost_error;
    int code = *error ? 4 : 0;
    if (message && *error) *message = *error;
    *error = NULL;
    return code;
}

int oidnGetDeviceInt(Device *device, const char *name)
{
    if (!strcmp(name, "version")) return 20999;
    if (!strcmp(name, "type")) return device->kind == 0 ? 1 : 3;
    if (!strcmp(name, "externalMemoryTypes")) return device->kind != 0 && device->kind != TAKES_NO_MEMORY;
    return 0;
}

static const unsigned char pretended_uuid[16] = {COPIES_COLOR};
int oidnGetNumPhysicalDevices(void) { return 2; }
int oidnGetPhysicalDeviceInt(int device, const char *name) { return strcmp(name, "type") ? 0 : device == 0 ? 1 : 3; }
bool oidnGetPhysicalDeviceBool(int device, const char *name) { return device == 1 && !strcmp(name, "uuidSupported"); }
const char *oidnGetPhysicalDeviceString(int device, const char *name)
{
    return strcmp(name, "name") ? NULL : device == 0 ? "processor" : "pretended GPU";
}
const void *oidnGetPhysicalDeviceData(int device, const char *name, size_t *bytes)
{
    if (device != 1 || strcmp(name, "uuid")) return *bytes = 0, NULL;
    *bytes = sizeof(pretended_uuid);
    return pretended_uuid;
}

Buffer *oidnNewBufferWithStorage(Device *device, size_t bytes, int storage)
{
    (void)storage;
    Buffer *buffer = calloc(1, sizeof(Buffer));
    *buffer = (Buffer){device, calloc(1, bytes ? bytes : 1), bytes};
    return buffer;
}

// Memory of Mesa's software Vulkan is a file, which begins with its size and the place of what is in it.
Buffer *oidnNewSharedBufferFromFD(Device *device, int type, int fd, size_t bytes)
{
    struct stat file;
    if (device->kind == REFUSES_MEMORY || type != 1 || fstat(fd, &file)) {
        device->error = "the memory cannot be imported";
        return NULL;
    }
    char *base = mmap(NULL, file.st_size, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    size_t header[2] = {0};
    if (base != MAP_FAILED) memcpy(header, base, sizeof(header));
    if (base == MAP_FAILED || header[1] + bytes > (size_t)file.st_size) {
        device->error = "the memory is not that of a software driver";
        return NULL;
    }
    Buffer *buffer = calloc(1, sizeof(Buffer));
    *buffer = (Buffer){device, base + header[1], bytes};
    return buffer;
}

void oidnReadBuffer(Buffer *buffer, size_t from, size_t bytes, void *to) { memcpy(to, buffer->data + from, bytes); }
void oidnWriteBuffer(Buffer *buffer, size_t to, size_t bytes, const void *from) { memcpy(buffer->data + to, from, bytes); }
// What it held is left behind: it may be somebody else's.
void oidnReleaseBuffer(Buffer *buffer) { free(buffer); }

Filter *oidnNewFilter(Device *device, const char *type)
{
    (void)type;
    Filter *filter = calloc(1, sizeof(Filter));
    filter->device = device;
    return filter;
}

void oidnReleaseFilter(Filter *filter) { free(filter); }

static void set(Filter *filter, const char *name, char *data, size_t width, size_t height, size_t pixel)
{
    Image image = {data, pixel ? pixel : 3 * sizeof(float), width, height};
    if (!strcmp(name, "color")) filter->color = image;
    if (!strcmp(name, "albedo")) filter->albedo = image;
    if (!strcmp(name, "normal")) filter->normal = image;
    if (!strcmp(name, "output")) filter->output = image;
}

void oidnSetFilterImage(Filter *filter, const char *name, Buffer *buffer, int format, size_t width, size_t height,
                        size_t offset, size_t pixel, size_t row)
{
    (void)format, (void)row;
    set(filter, name, buffer->data + offset, width, height, pixel);
}

void oidnSetSharedFilterImage(Filter *filter, const char *name, void *data, int format, size_t width, size_t height,
                              size_t offset, size_t pixel, size_t row)
{
    (void)format, (void)row;
    set(filter, name, (char *)data + offset, width, height, pixel);
}

void oidnSetFilterBool(Filter *filter, const char *name, bool value) { (void)filter, (void)name, (void)value; }
void oidnSetFilterInt(Filter *filter, const char *name, int value) { (void)filter, (void)name, (void)value; }
void oidnCommitFilter(Filter *filter) { (void)filter; }

void oidnExecuteFilter(Filter *filter)
{
    int kind = filter->device->kind;
    if (kind == RUNS_OUT_OF_MEMORY) {
        filter->device->error = "out of memory";
        return;
    }
    // A guide alone stays as it is.
    Image from = filter->color.data ? filter->color : filter->albedo.data ? filter->albedo : filter->normal;
    if (filter->color.data && kind == COPIES_ALBEDO) from = filter->albedo;
    if (filter->color.data && kind == COPIES_NORMAL) from = filter->normal;
    for (size_t i = 0; i < filter->output.width * filter->output.height; i++) {
        float pixel[3];
        memcpy(pixel, from.data + i * from.pixel, sizeof(pixel));
        memcpy(filter->output.data + i * filter->output.pixel, pixel, sizeof(pixel));
    }
}
