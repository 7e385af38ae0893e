"""Loss between predicted and true inverse depth, whatever the prediction's scale and shift."""
import torch
import torch.nn.functional as F


def normalized(x):
    """Per picture: minus median, divided by mean absolute deviation. [n, 1, h, w]"""
    flat = x.flatten(1)
    centred = flat - flat.median(1, keepdim=True).values
    return (centred / centred.abs().mean(1, keepdim=True).clamp(min=0.02)).view_as(x)


def ranks(x):
    """Ranks of a coarse copy, -1..1. [n, pixels]"""
    flat = x.flatten(1)
    order = flat.argsort(1).argsort(1).float()
    return order / (flat.shape[1] - 1) * 2 - 1


def correlation(a, b):
    a = a - a.mean(1, keepdim=True)
    b = b - b.mean(1, keepdim=True)
    return (a * b).sum(1) / (a.norm(dim=1) * b.norm(dim=1) + 1e-6)


def gradients(difference, scales=4):
    total = 0
    for scale in range(scales):
        d = difference[:, :, ::2 ** scale, ::2 ** scale]
        total = total + (d[:, :, 1:] - d[:, :, :-1]).abs().mean() \
            + (d[..., 1:] - d[..., :-1]).abs().mean()
    return total


def depth_loss(prediction, truth):
    """`truth` is linear inverse depth 0..1; the prediction learns its square root."""
    target = normalized(truth.sqrt())
    own = normalized(prediction)
    difference = own - target
    # a very near thing has a large deviation: it counts, but not more than all the rest
    error = F.smooth_l1_loss(own, target, beta=0.1, reduction="none")
    error = torch.where(error < 2, error, 2 + 0.1 * (error - 2)).mean()
    small = truth[:, :, 2::4, 2::4] + 1e-6 * torch.rand_like(truth[:, :, 2::4, 2::4])
    order = 1 - correlation(prediction[:, :, 2::4, 2::4].flatten(1), ranks(small)).mean()
    return error + 0.5 * gradients(difference.clamp(-4, 4)) + 0.5 * order, error, order
