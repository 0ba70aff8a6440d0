"""Contacts of elastic bodies: laws, friction and materials, without a scene.

* `materials`: elastic constants and densities, and moduli of two bodies in contact.
* `elasticity`: loads, approaches, energies and ellipses of Hertzian contacts.
* `laws`: the table of elastic laws, and damping by restitution.
* `line`: line contacts of discs: loads, energies and closed forms of their impact.
* `hertz_impact`: closed forms of the impact of spheres.
* `friction`: the table of friction models, and friction over a contact patch.
* `validity`: limits of the theory of contacts, and the warnings beyond them.
* `calculator`: a contact by all laws, from radii, curvatures or a groove.
* `picture`: the picture of a contact, `plot_contact`.
"""
