"""Loss between predicted and true inverse depth, whatever the prediction's scale and shift."""
import torch
import torch.nn.functional as F


def normalized(x):
    """Per picture: (x - median) / mean absolute deviation; with both numbers. [n, 1, h, w]"""
    flat = x.flatten(1)
    median = flat.median(1, keepdim=True).values
    deviation = (flat - median).abs().mean(1, keepdim=True)
    return ((flat - median) / deviation.clamp(min=0.02)).view_as(x), median, deviation


def ranks(x):
    """Ranks of a coarse copy, -1..1. [n, pixels]"""
    flat = x.flatten(1)
    order = flat.argsort(1).argsort(1).float()
    return order / (flat.shape[1] - 1) * 2 - 1


def correlation(a, b):
    a = a - a.mean(1, keepdim=True)
    b = b - b.mean(1, keepdim=True)
    return (a * b).sum(1) / (a.norm(dim=1) * b.norm(dim=1) + 1e-6)


def gradients(own, true, distances=(1, 2, 4, 8), least=0.15):
    """Mean error of differences over some distances. Edges, where the true difference is above `least`,
    count as much as all the rest: else the safe guess is a plain ramp, as edges are rare."""
    total = 0
    for d in distances:
        for a, b in ((own[:, :, d:] - own[:, :, :-d], true[:, :, d:] - true[:, :, :-d]),
                     (own[..., d:] - own[..., :-d], true[..., d:] - true[..., :-d])):
            error = (a - b).abs()
            error = torch.where(error < 1, error, 1 + 0.1 * (error - 1))
            edge = (b.abs() > least).float()
            shares = edge.mean((1, 2, 3))
            at_edges = (error * edge).mean((1, 2, 3)) / (shares + 0.01)
            elsewhere = (error * (1 - edge)).mean((1, 2, 3)) / (1 - shares + 0.01)
            total = total + (at_edges + elsewhere).mean()
    return total / (2 * len(distances))


def patches(x, side):
    """[n * patches, side * side], without their means."""
    n, _, h, w = x.shape
    x = x[:, :, :h // side * side, :w // side * side]
    x = x.reshape(n, h // side, side, w // side, side).transpose(2, 3).reshape(-1, side * side)
    return x - x.mean(1, keepdim=True)


def local_order(prediction, target, side):
    """Correlation inside patches: rewards edges where the large layout is still wrong."""
    own, true = patches(prediction, side), patches(target, side)
    weight = (true.norm(dim=1) / side).clamp(max=0.5)  # nothing to learn from plain patches
    cosine = (own * true).sum(1) / (own.norm(dim=1) * true.norm(dim=1) + 1e-2)
    return ((1 - cosine) * weight).sum() / (weight.sum() + 1e-6)


def depth_loss(prediction, truth, weight):
    """`truth` is linear inverse depth 0..1; the prediction learns its square root."""
    target = normalized(truth.sqrt())[0]
    own, median, deviation = normalized(prediction)
    # Without this the scale of the coarsest level grows, and the finer ones can add nothing to it.
    size = (deviation - 1).square().mean() + median.square().mean()
    # a very near thing has a large deviation: it counts, but not more than all the rest
    error = F.smooth_l1_loss(own, target, beta=0.1, reduction="none")
    error = torch.where(error < 2, error, 2 + 0.1 * (error - 2)).mean()
    small = truth[:, :, 2::4, 2::4]
    small = small + 1e-6 * torch.rand_like(small)  # equal values in random order
    order = 1 - correlation(prediction[:, :, 2::4, 2::4].flatten(1), ranks(small)).mean()
    local = local_order(own, target, 16) + local_order(own[..., ::2, ::2], target[..., ::2, ::2], 48)
    edges = gradients(own, target)
    return error + 0.1 * size + weight * edges + 0.5 * order + 0.25 * local, error, order, edges


def layout_loss(prediction, other):
    """Mean difference of two predictions of the same picture, without what is finer than an eighth of `other`."""
    size = [max(1, side // 8) for side in other.shape[2:]]
    a, b = (normalized(F.adaptive_avg_pool2d(x, size))[0] for x in (prediction, other))
    return (a - b).abs().mean()


def hiding_loss(prediction, where, margin=0.3):
    """For photos without depth: a thing is nearer than what is seen beside and above it, and has no
    edges inside. `where` is 255 inside the thing, 128 around it, 0 elsewhere."""
    own = normalized(prediction)[0]
    inside, outside = (where == 255).float(), (where == 128).float()

    def near(x, side):
        return F.avg_pool2d(x, side, 1, side // 2)

    def mean(x, weight):
        return (x * weight).sum() / (weight.sum() + 1)

    share_in, share_out = near(inside, 13), near(outside, 13)
    step = near(own * inside, 13) / share_in.clamp(min=0.01) - \
        near(own * outside, 13) / share_out.clamp(min=0.01)
    order = mean(F.relu(margin - step), ((share_in > 0.1) & (share_out > 0.1)).float())
    inner = (near(inside, 7) > 0.99).float()
    slope = mean(F.relu((own[..., 2:] - own[..., :-2]).abs() - 0.03), inner[..., 2:] * inner[..., :-2]) + \
        mean(F.relu((own[:, :, 2:] - own[:, :, :-2]).abs() - 0.03), inner[:, :, 2:] * inner[:, :, :-2])
    return order, slope
