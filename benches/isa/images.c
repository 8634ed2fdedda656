// Tells which images a driver compresses: prints a line of JSON for each format and usage, of the first Vulkan device there is.
//
// Asks VK_EXT_image_compression_control how an image of 1280×800 is laid out. No GPU is needed: the layout is decided by the driver.
#include <stdio.h>
#include <stdlib.h>
#include <vulkan/vulkan.h>

static void check(VkResult result, const char *what) {
    if (result) {
        fprintf(stderr, "isa: %s: error %d\n", what, result);
        exit(1);
    }
}

static VkPhysicalDevice physical;

static VkDevice make_device(void) {
    VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    VkInstanceCreateInfo instance_info = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &app};
    VkInstance instance;
    check(vkCreateInstance(&instance_info, NULL, &instance), "no Vulkan");
    uint32_t count = 1;
    vkEnumeratePhysicalDevices(instance, &count, &physical);
    check(physical ? VK_SUCCESS : VK_ERROR_DEVICE_LOST, "no device");

    VkPhysicalDeviceImageCompressionControlFeaturesEXT control = {
        .sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_IMAGE_COMPRESSION_CONTROL_FEATURES_EXT, .imageCompressionControl = VK_TRUE};
    float priority = 1;
    VkDeviceQueueCreateInfo queue = {
        .sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
    const char *extension = VK_EXT_IMAGE_COMPRESSION_CONTROL_EXTENSION_NAME;
    VkDeviceCreateInfo info = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                               .pNext = &control,
                               .queueCreateInfoCount = 1,
                               .pQueueCreateInfos = &queue,
                               .enabledExtensionCount = 1,
                               .ppEnabledExtensionNames = &extension};
    VkDevice device;
    check(vkCreateDevice(physical, &info, NULL, &device), "the device does not tell what it compresses");
    return device;
}

// As wgpu creates a texture without view formats.
static const char *compression(VkDevice device, VkFormat format, VkImageUsageFlags usage) {
    VkImageCreateInfo info = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                              .imageType = VK_IMAGE_TYPE_2D,
                              .format = format,
                              .extent = {1280, 800, 1},
                              .mipLevels = 1,
                              .arrayLayers = 1,
                              .samples = VK_SAMPLE_COUNT_1_BIT,
                              .tiling = VK_IMAGE_TILING_OPTIMAL,
                              .usage = usage};
    VkImageFormatProperties supported;
    if (vkGetPhysicalDeviceImageFormatProperties(physical, format, info.imageType, info.tiling, usage, 0, &supported))
        return "unsupported";
    VkImage image;
    if (vkCreateImage(device, &info, NULL, &image))
        return "unsupported";
    VkImageCompressionPropertiesEXT properties = {.sType = VK_STRUCTURE_TYPE_IMAGE_COMPRESSION_PROPERTIES_EXT};
    VkSubresourceLayout2EXT layout = {.sType = VK_STRUCTURE_TYPE_SUBRESOURCE_LAYOUT_2_EXT, .pNext = &properties};
    VkImageSubresource2EXT of = {.sType = VK_STRUCTURE_TYPE_IMAGE_SUBRESOURCE_2_EXT,
                                 .imageSubresource = {.aspectMask = VK_IMAGE_ASPECT_COLOR_BIT}};
    PFN_vkGetImageSubresourceLayout2EXT get =
        (PFN_vkGetImageSubresourceLayout2EXT)vkGetDeviceProcAddr(device, "vkGetImageSubresourceLayout2EXT");
    get(device, image, &of, &layout);
    vkDestroyImage(device, image, NULL);
    return properties.imageCompressionFlags == VK_IMAGE_COMPRESSION_DISABLED_EXT ? "no" : "yes";
}

int main(void) {
    static const struct {
        const char *name;
        VkFormat format;
    } formats[] = {
        {"Rgba16Float", VK_FORMAT_R16G16B16A16_SFLOAT},
        {"Rg32Uint", VK_FORMAT_R32G32_UINT},
        {"R32Uint", VK_FORMAT_R32_UINT},
        {"R8Unorm", VK_FORMAT_R8_UNORM},
    };
    static const struct {
        const char *name;
        VkImageUsageFlags usage;
    } usages[] = {
        {"attachment", VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT},
        {"attachment, storage", VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_STORAGE_BIT},
        {"storage", VK_IMAGE_USAGE_STORAGE_BIT},
    };
    VkDevice device = make_device();
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical, &properties);
    for (size_t f = 0; f < sizeof formats / sizeof *formats; f++)
        for (size_t u = 0; u < sizeof usages / sizeof *usages; u++)
            printf("{\"device\":\"%s\",\"format\":\"%s\",\"usage\":\"%s\",\"compressed\":\"%s\"}\n", properties.deviceName,
                   formats[f].name, usages[u].name,
                   compression(device, formats[f].format,
                               usages[u].usage | VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                   VK_IMAGE_USAGE_TRANSFER_DST_BIT));
    return 0;
}
